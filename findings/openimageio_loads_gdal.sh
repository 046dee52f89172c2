#!/usr/bin/env bash
# A program that reads one PNG by Debian's OpenImageIO loads some 250 shared libraries at its start, a database's client and
# a map reader's among them, and its start costs more processor time than all else that it does.
#
# Seen with: Debian 12's libopenimageio-dev 2.4.7.1+dfsg-2, libopencv 4.6.0+dfsg-12.
# Input: a program whose only call is OIIO::ImageInput::open, and one that reads a PNG by libpng itself.
# Output: `ldd` lists more than 200 libraries for the first, GDAL, libpq and libavformat among them, fewer than 12 for the
# second. The chain: OpenImageIO -> OpenCV's videoio (for webcams) -> imgcodecs -> GDAL -> databases.
# Why it matters: a pipeline of many small programs spends its time in the dynamic linker (here .6 of .66 s a start). Loaded
# with dlopen at the first picture, the same programs start in a fifteenth.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install libopenimageio-dev=2.4.7.1+dfsg-2 libopenimageio2.4=2.4.7.1+dfsg-2 \
  >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
libraries="$work/root/usr/lib/x86_64-linux-gnu"

cat >picture.cpp <<'CPP'
#include <OpenImageIO/imageio.h>

int main(int, char** files) { return OIIO::ImageInput::open(files[1]) ? 0 : 1; }
CPP
cat >png.cpp <<'CPP'
#include <png.h>

int main() { return png_access_version_number() > 0 ? 0 : 1; }
CPP
g++ -w -I root/usr/include picture.cpp -o picture -L "$libraries" -lOpenImageIO -lOpenImageIO_Util
g++ -w png.cpp -o png -lpng16
export LD_LIBRARY_PATH="$libraries"
loaded=$(ldd picture | wc -l)
plain=$(ldd png | wc -l)
among=$(ldd picture | grep -oE 'lib(gdal|pq|avformat|opencv_videoio)\.so' | sort -u | xargs)
echo "OpenImageIO: $loaded libraries, among them $among; libpng: $plain"
if [ "$loaded" -gt 200 ] && [ "$plain" -lt 12 ] &&
  [ "$among" = "libavformat.so libgdal.so libopencv_videoio.so libpq.so" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
