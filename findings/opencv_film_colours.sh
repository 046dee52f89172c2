#!/usr/bin/env bash
# OpenCV 4.6 decodes all films with the colour matrix of standard definition, and 10-bit films of full range as
# narrow ones, whatever the file says.
#
# Seen with: Debian 12's python3-opencv 4.6.0+dfsg-12; films by ffmpeg 5.1.9-0+deb12u1.
# Input: one colour (200, 60, 40) in four films: BT.601; BT.709, named in the stream, as cameras of today do;
# BT.709 in full range with 8 bits, and with 10 bits. ffmpeg gives the colour back from each within 2 levels.
# Output: OpenCV gives back (201, 61, 40) from the first, but (187, 47, 42), (188, 46, 42) and (197, 37, 32) from
# the others.
# Why it matters: colours of films and of photographs of the same thing differ, here by 13 levels, and by other amounts
# for other hues: a background learned from stills does not fit the film, nor a filmed texture a baked one. Two films of
# one scene, with 8 and with 10 bits, also differ from each other.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install python3-opencv=4.6.0+dfsg-12 python3-numpy=1:1.24.2-1+deb12u1 \
  ffmpeg=7:5.1.9-0+deb12u1 >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
export PATH="$work/root/usr/bin:/usr/bin:$PATH" PYTHONPATH="$work/root/usr/lib/python3/dist-packages"
libraries="$work/root/usr/lib/x86_64-linux-gnu"
export LD_LIBRARY_PATH="$libraries:$libraries/blas:$libraries/lapack"

film() {  # name, matrix of the scaler, name of it in the stream, range, pixels, encoder and its quantiser
  ffmpeg -v error -f lavfi -i "color=c=0xC83C28:s=96x64:r=25:d=0.2,format=rgb24" \
    -vf "scale=out_color_matrix=$2:out_range=$4,format=$5" -c:v "${@:6}" -threads 1 \
    -colorspace "$3" -color_range "$4" "$1.mp4"
}
film sd bt601 smpte170m tv yuv444p libx264 -qp 1
film hd bt709 bt709 tv yuv444p libx264 -qp 1
film hd_full bt709 bt709 pc yuv444p libx264 -qp 1
film hd_full_10 bt709 bt709 pc yuv444p10le libx265 -x265-params log-level=none:qp=1
/usr/bin/python3 - <<'PY'
import subprocess, sys
import cv2

true = (200, 60, 40)
seen = {"sd": (201, 61, 40), "hd": (187, 47, 42), "hd_full": (188, 46, 42), "hd_full_10": (197, 37, 32)}
same = True
for name, expected in seen.items():
    bgr = cv2.VideoCapture(name + ".mp4", cv2.CAP_FFMPEG).read()[1][32, 48]
    by_opencv = tuple(int(value) for value in bgr[::-1])
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", name + ".mp4", "-frames:v", "1", "-vf", "scale=out_range=pc",
                          "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], check=True, capture_output=True).stdout
    at = 3 * (32 * 96 + 48)
    by_ffmpeg = tuple(raw[at:at + 3])
    print(f"{name}: colour {true}, ffmpeg {by_ffmpeg}, OpenCV {by_opencv}")
    same = same and max(abs(a - b) for a, b in zip(by_ffmpeg, true)) <= 2
    same = same and max(abs(a - b) for a, b in zip(by_opencv, expected)) <= 2
print("as before" if same else "CHANGED")
sys.exit(0 if same else 1)
PY
