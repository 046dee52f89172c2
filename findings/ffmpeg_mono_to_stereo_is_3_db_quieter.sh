#!/usr/bin/env bash
# One channel that ffmpeg makes two of is 3 dB quieter on both, though nothing could clip.
#
# Seen with: Debian 12's ffmpeg 5.1.9-0+deb12u1 (libswresample 4.7).
# Input: a tone of half of full scale in one channel.
# Output: `-ac 2` gives both channels 0.707 of it, in 16 bits and in floating point: peaks of -9.0 dB instead of -6.0 dB.
# The centre's share of a mix is used where the centre is all there is.
# Why it matters: dialogue recorded with one microphone comes out quieter in a film than in the file; a player gives it
# at full level to both sides.
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

peak() { ffmpeg -hide_banner -i "$1" -af volumedetect -f null - 2>&1 | sed -n 's/.*max_volume: //p'; }
ffmpeg -v error -f lavfi -i "aevalsrc=0.5*sin(2*PI*441*t):sample_rate=48000:duration=1" -c:a pcm_s16le mono.wav
{
  echo "one channel: $(peak mono.wav)"
  for kind in pcm_s16le pcm_f32le; do
    ffmpeg -v error -i mono.wav -ac 2 -c:a $kind $kind.wav
    echo "two, $kind: $(peak $kind.wav)"
  done
} | tee result
if [ "$(cat result)" = "one channel: -6.0 dB
two, pcm_s16le: -9.0 dB
two, pcm_f32le: -9.0 dB" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
