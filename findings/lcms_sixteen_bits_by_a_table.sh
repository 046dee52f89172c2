#!/usr/bin/env bash
# Little CMS converts 16-bit RGB to RGB by a table of colours unless told otherwise: Display P3 to sRGB is thousands of
# steps off.
#
# Seen with: Debian 12's liblcms2-dev 2.14-2+deb12u1, x86-64.
# Input: a million colours of 16 bits, a profile with the primaries of Display P3 and the curve of sRGB, relative
# colorimetric intent; beside them the same by the primaries' matrix and the curve, clipped.
# Output: by default, and with cmsFLAGS_HIGHRESPRECALC, the largest difference is above 2,000 of 65,535 steps; with
# cmsFLAGS_NOOPTIMIZE it is below 100. 8 bits take a path without the table.
# Why it matters: a 16-bit photograph of a phone comes out less exact than the same one in 8 bits.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install liblcms2-dev=2.14-2+deb12u1 liblcms2-2=2.14-2+deb12u1 \
  >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
libraries="$work/root/usr/lib/x86_64-linux-gnu"

cat >steps.cpp <<'CPP'
#include <lcms2.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

double Linear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double Encoded(double v) {
  v = std::clamp(v, 0.0, 1.0);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

int main() {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  const cmsCIExyYTRIPLE primaries{{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}};
  const double curve_numbers[] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  cmsToneCurve* curve = cmsBuildParametricToneCurve(nullptr, 4, curve_numbers);
  cmsToneCurve* curves[] = {curve, curve, curve};
  const cmsHPROFILE p3 = cmsCreateRGBProfile(&white, &primaries, curves), srgb = cmsCreate_sRGBProfile();
  const double matrix[3][3] = {{1.2249401, -0.2249404, 0}, {-0.0420569, 1.0420571, 0}, {-0.0196376, -0.0786361, 1.0982735}};
  constexpr int kPixels = 1000000;
  std::vector<std::uint16_t> in(3 * kPixels), out(3 * kPixels);
  unsigned seed = 1;
  for (auto& x : in) x = static_cast<std::uint16_t>((seed = seed * 1664525 + 1013904223) >> 16);
  const struct { const char* name; cmsUInt32Number flags; } ways[] = {
      {"default", 0}, {"HIGHRESPRECALC", cmsFLAGS_HIGHRESPRECALC}, {"NOOPTIMIZE", cmsFLAGS_NOOPTIMIZE}};
  for (const auto& way : ways) {
    const cmsHTRANSFORM transform =
        cmsCreateTransform(p3, TYPE_RGB_16, srgb, TYPE_RGB_16, INTENT_RELATIVE_COLORIMETRIC, way.flags);
    cmsDoTransform(transform, in.data(), out.data(), kPixels);
    double largest = 0;
    for (int i = 0; i < 3 * kPixels; i += 3)
      for (int c = 0; c < 3; ++c) {
        double linear = 0;
        for (int k = 0; k < 3; ++k) linear += matrix[c][k] * Linear(in[i + k] / 65535.0);
        largest = std::max(largest, std::abs(out[i + c] - 65535 * Encoded(linear)));
      }
    std::fprintf(stderr, "%s: largest difference %.0f of 65535 steps\n", way.name, largest);
    std::printf("%s: %s\n", way.name, largest > 2000 ? "above 2000" : largest < 100 ? "below 100" : "between");
  }
}
CPP
g++ -O2 -std=c++17 -isystem root/usr/include steps.cpp -L"$libraries" -llcms2 -o steps
LD_LIBRARY_PATH="$libraries" ./steps | tee result
if [ "$(cat result)" = "default: above 2000
HIGHRESPRECALC: above 2000
NOOPTIMIZE: below 100" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
