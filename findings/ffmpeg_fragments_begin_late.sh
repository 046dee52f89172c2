#!/usr/bin/env bash
# A fragmented MP4 of ffmpeg begins two pictures late where the same film as a plain MP4 begins at 0.
#
# Seen with: Debian 12's ffmpeg 5.1.9-0+deb12u1.
# Input: two seconds of H.264 with two B pictures, copied with `-movflags frag_keyframe+empty_moov`, as live
# encoders write.
# Output: the plain file's edit list takes out the delay of the B pictures; an empty header comes before the first
# picture and has no edit list, so the first picture is shown at 0.08 s.
# Why it matters: two films of one moment, one of them fragmented, are two pictures apart if they are joined by time.
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
ffmpeg -v error -i film.mp4 -c copy -movflags frag_keyframe+empty_moov fragments.mp4
for film in film fragments; do
  echo "$film: first picture at $(ffprobe -v error -show_entries frame=best_effort_timestamp_time -of csv=p=0 $film.mp4 | head -1 | cut -d, -f1)"
done | tee result
if [ "$(cat result)" = "film: first picture at 0.000000
fragments: first picture at 0.080000" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
