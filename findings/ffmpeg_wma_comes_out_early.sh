#!/usr/bin/env bash
# Sound that FFmpeg writes as Windows Media Audio comes out of FFmpeg 2048 samples early: 43 ms at 48 kHz, a frame of film.
#
# Seen with: Debian 12's ffmpeg 5.1.9-0+deb12u1.
# Input: one second of silence with a tone from 0.25 s on, at 48 kHz, as WAV, Opus, AAC (.m4a), MP3, WMA 1 and WMA 2 (.wma),
# each read back as raw samples.
# Output: where the tone begins. WAV, Opus, AAC and MP3: at 12000 samples, to a few dozen. Both kinds of WMA: 2048 before
# that; nothing is said, and start times in the file are 0.
# Why it matters: lips are timed to sound by the frame.
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

ffmpeg -v error -f lavfi -i "sine=frequency=1000:sample_rate=48000:duration=1,volume=enable='lt(t,0.25)':volume=0" \
  -c:a pcm_s16le tone.wav
begin() {  # the first sample above a tenth of the loudest
  ffmpeg -v error -i "$1" -f s16le -ac 1 -ar 48000 raw -y
  od -An -v -t d2 -w2 raw | awk '{ v[NR] = $1 < 0 ? -$1 : $1; if (v[NR] > top) top = v[NR] }
    END { for (i = 1; i <= NR; ++i) if (v[i] > top / 10) { print i - 1; exit } }'
}
at=$(begin tone.wav)
changed=0
for kind in "opus libopus" "m4a aac" "mp3 libmp3lame" "wma wmav1" "wma wmav2"; do
  set -- $kind
  ffmpeg -v error -i tone.wav -c:a "$2" -b:a 128k "tone.$1" -y
  early=$((at - $(begin "tone.$1")))
  echo "$2: $early samples early"
  case $2 in
    wma*) [ $early -gt 1900 ] && [ $early -lt 2200 ] || changed=1 ;;
    *) [ $early -gt -400 ] && [ $early -lt 400 ] || changed=1 ;;
  esac
done
if [ $changed = 0 ]; then echo "as before"; else echo "CHANGED" && exit 1; fi
