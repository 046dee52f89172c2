#!/usr/bin/env bash
# H.264 copied into an AVI by ffmpeg claims twice its pictures and twice their rate.
#
# Seen with: Debian 12's ffmpeg 5.1.9-0+deb12u1.
# Input: two seconds of H.264 at 25 pictures a second (50 pictures), copied from MP4 to AVI (`-c copy`).
# Output: ffprobe gives the AVI nb_frames=100 and avg_frame_rate=50/1, and packets have no presentation times. Its
# storing times (DTS) are right, r_frame_rate is 25/1, and 50 pictures come out of it.
# Why it matters: who takes a picture's number from the average rate or the count is off by a factor of two.
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

ffmpeg -v error -f lavfi -i testsrc=size=64x48:rate=25:duration=2 -c:v libx264 -threads 1 -bf 2 film.mp4
ffmpeg -v error -i film.mp4 -c copy film.avi
for film in film.mp4 film.avi; do
  echo "$film: $(ffprobe -v error -show_entries stream=avg_frame_rate,nb_frames -of csv=p=0 $film), \
$(ffmpeg -v error -i $film -f framemd5 - | grep -vc '^#') pictures"
done | tee result
echo "first packets: $(ffprobe -v error -show_entries packet=pts_time,dts_time -of csv=p=0 film.avi | head -3 | xargs)" | tee -a result
if [ "$(cat result)" = "film.mp4: 25/1,50, 50 pictures
film.avi: 50/1,100, 50 pictures
first packets: N/A,0.000000 N/A,0.040000 N/A,0.080000" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
