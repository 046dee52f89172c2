#!/usr/bin/env bash
# OpenCV 4.6 shows a film that was shot upright turned the wrong way: by half a turn from what is right.
#
# Seen with: Debian 12's python3-opencv 4.6.0+dfsg-12 on its libavformat 59; films by ffmpeg 5.1.9-0+deb12u1.
# Input: an MP4 whose left upper quarter is red, with the matrix that a telephone held upright writes into the
# track header: (x, y) goes to (64 - y, x), a quarter turn clockwise, which brings that quarter to the upper right.
# Output: ffmpeg shows it at the upper right. OpenCV turns anticlockwise and shows it at the lower left. A matrix
# that turns anticlockwise is taken for clockwise; half a turn is right. Sizes are right in all cases, and OpenCV
# says that it turns pictures by itself (CAP_PROP_ORIENTATION_AUTO), so nothing looks amiss but the picture.
# Why it matters: cameras of a rig that hang upright give films on their heads beside films that stand, while stills
# of the same cameras are right: calibration by stills does not fit the films.
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

ffmpeg -v error -f lavfi -i "color=c=black:s=96x64:r=25:d=0.4,drawbox=0:0:48:32:red:fill" \
  -c:v libx264 -threads 1 -pix_fmt yuv420p plain.mp4
/usr/bin/python3 - <<'PY'
import struct, subprocess, sys
import cv2

plain = open("plain.mp4", "rb").read()
# In a track header of version 0 the matrix begins 40 bytes after the version.
at = plain.index(b"tkhd") + 4 + 40
assert struct.unpack(">9i", plain[at:at + 36])[::4] == (65536, 65536, 1 << 30)

def matrix(a, b, c, d, x, y):
    one = 65536
    return struct.pack(">9i", a * one, b * one, 0, c * one, d * one, 0, x * one, y * one, 1 << 30)

def red_quarter(picture):
    rows, columns = picture.shape[:2]
    for name, row, column in (("upper left", 1, 1), ("upper right", 1, 3), ("lower left", 3, 1), ("lower right", 3, 3)):
        if picture[row * rows // 4, column * columns // 4][2] > 128:
            return name

turns = {"clockwise": (matrix(0, 1, -1, 0, 64, 0), "upper right", "lower left"),
         "anticlockwise": (matrix(0, -1, 1, 0, 0, 96), "lower left", "upper right"),
         "half a turn": (matrix(-1, 0, 0, -1, 96, 64), "lower right", "lower right")}
same = True
for turn, (bytes_of, right, seen) in turns.items():
    open("film.mp4", "wb").write(plain[:at] + bytes_of + plain[at + 36:])
    film = cv2.VideoCapture("film.mp4", cv2.CAP_FFMPEG)
    by_opencv = film.read()[1]
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", "film.mp4", "-frames:v", "1", "by_ffmpeg.png"], check=True)
    by_ffmpeg = cv2.imread("by_ffmpeg.png")
    print(f"{turn}: by the matrix {right}; ffmpeg {red_quarter(by_ffmpeg)}; OpenCV {red_quarter(by_opencv)}"
          f" (size {by_opencv.shape[1]} x {by_opencv.shape[0]}, turns itself: "
          f"{film.get(cv2.CAP_PROP_ORIENTATION_AUTO) == 1})")
    same = same and red_quarter(by_ffmpeg) == right and red_quarter(by_opencv) == seen
    same = same and by_opencv.shape == by_ffmpeg.shape
print("as before" if same else "CHANGED")
sys.exit(0 if same else 1)
PY
