#!/usr/bin/env bash
# Eigen's `colwise().mean()` of a row-major N x 3 matrix has other last bits where the result lies at another address.
#
# Seen with: Debian 12's libeigen3-dev 3.4.0-4, its g++ 12, -O2, x86-64.
# Input: 1,001 points; the mean is written to an address that is a multiple of 16, and to one 8 bytes further.
# Output: columns that are computed two at a time add in another order than one that is computed alone, and which
# column that is goes by the address: the first and the last column differ in their last digits.
# Why it matters: a new member in a class in front of such a vector changes the bits of all that follows from it; a
# decimation by edge costs then takes other edges.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install libeigen3-dev=3.4.0-4 >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done

cat >mean.cpp <<'CPP'
#include <Eigen/Core>
#include <cstdio>
#include <new>

int main() {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> points(1001, 3);
  for (int i = 0; i < points.size(); ++i) points.data()[i] = 1.0 / (1 + i);
  alignas(16) unsigned char room[64];
  for (int shift : {0, 8}) {
    auto* mean = new (room + shift) Eigen::RowVector3d;
    *mean = points.colwise().mean();
    std::printf("at 16 n + %d: %.17g %.17g %.17g\n", shift, (*mean)[0], (*mean)[1], (*mean)[2]);
  }
}
CPP
g++ -O2 -std=c++17 -isystem root/usr/include/eigen3 mean.cpp -o mean
./mean | tee result
if [ "$(cat result)" = "at 16 n + 0: 0.0033435304984695728 0.0027396455953973709 0.0024929969568928852
at 16 n + 8: 0.003343530498469575 0.0027396455953973709 0.0024929969568928886" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
