#!/usr/bin/env bash
# Bare streams of JPEGs and of AV1 get times of 25 pictures a second, and nothing says that these are invented.
#
# Seen with: Debian 12's ffmpeg 5.1.9-0+deb12u1.
# Input: one second of 12 pictures a second, as a stream of JPEGs (.mjpeg) and as AV1 (.obu), and as H.264 (.h264).
# Output: packets of the first two have presentation times 1/25 s apart, and r_frame_rate=25/1; of H.264 they have
# none, and r_frame_rate is 12/1, as its own header says.
# Why it matters: who trusts a packet's time plays these twice as fast. The format's flag AVFMT_NOTIMESTAMPS tells.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install ffmpeg=7:5.1.9-0+deb12u1 >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
libraries="$work/root/usr/lib/x86_64-linux-gnu"
export PATH="$work/root/usr/bin:/usr/bin:$PATH" LD_LIBRARY_PATH="$libraries:$libraries/blas:$libraries/lapack"

source_film=(-f lavfi -i testsrc=size=64x64:rate=12:duration=1)
ffmpeg -v error "${source_film[@]}" -pix_fmt yuvj420p -c:v mjpeg film.mjpeg
ffmpeg -v error "${source_film[@]}" -pix_fmt yuv420p -c:v libaom-av1 -cpu-used 8 film.obu
ffmpeg -v error "${source_film[@]}" -pix_fmt yuv420p -c:v libx264 -threads 1 film.h264
for film in film.mjpeg film.obu film.h264; do
  echo "$film: $(ffprobe -v error -show_entries stream=r_frame_rate -of csv=p=0 $film), \
$(ffprobe -v error -show_entries packet=pts_time -of csv=p=0 $film | head -3 | xargs)"
done | tee result
if [ "$(cat result)" = "film.mjpeg: 25/1, 0.000000 0.040000 0.080000
film.obu: 25/1, 0.000000 0.040000 0.080000
film.h264: 12/1, N/A N/A N/A" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
