#!/usr/bin/env bash
# A source that includes cpp-httplib 0.11 and then Eigen does not compile; in the other order it does. Both headers are
# right by themselves: httplib includes the C library's resolv.h, which defines the macro _res, and Eigen has parameters
# of that name.
#
# Seen with: Debian 12's libcpp-httplib-dev 0.11.4+ds-1+deb12u1, libeigen3-dev 3.4.0-4, libc6-dev 2.36, its g++ 12.
# Input: two sources of two include lines each.
# Output: Eigen first: compiles. httplib first: "no declaration matches" in Eigen's products
# (SelfadjointMatrixMatrix.h, TriangularMatrixMatrix.h). With `#undef _res` between them: compiles.
# Why it matters: sources that are compiled together in one (CMake's UNITY_BUILD) meet by their order in a list, so a
# new or renamed source of a server breaks another's Eigen.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install libcpp-httplib-dev=0.11.4+ds-1+deb12u1 libeigen3-dev=3.4.0-4 \
  >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done

# compiles NAME LINE...: whether a source of these lines compiles; its messages are in NAME.log.
compiles() {
  local name=$1
  shift
  printf '%s\n' "$@" >"$name.cpp"
  g++ -std=c++17 -fsyntax-only -I root/usr/include -I root/usr/include/eigen3 "$name.cpp" >"$name.log" 2>&1
}

compiles eigen_first '#include <Eigen/Dense>' '#include <httplib.h>' || { cat eigen_first.log; exit 1; }
echo "Eigen, then httplib: compiles"
if compiles httplib_first '#include <httplib.h>' '#include <Eigen/Dense>'; then
  echo "httplib, then Eigen compiles now: the finding no longer holds"
  exit 1
fi
grep -q 'SelfadjointMatrixMatrix.h.*no declaration matches' httplib_first.log || { cat httplib_first.log; exit 1; }
echo "httplib, then Eigen: $(grep -c ' error: ' httplib_first.log) errors, all within Eigen"
compiles undefined '#include <httplib.h>' '#undef _res' '#include <Eigen/Dense>' || { cat undefined.log; exit 1; }
echo "httplib, then #undef _res, then Eigen: compiles"
