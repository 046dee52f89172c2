#!/usr/bin/env bash
# OpenCV 4.6 gives the corners of a ChArUco board half a pixel to the right of and below where its own functions of
# calibration expect them.
#
# Seen with: Debian 12's python3-opencv 4.6.0+dfsg-12.
# Input: the board's own drawing (7 x 5 squares, DICT_5X5_100), seen straight on with squares of 40 pixels and through a
# slight perspective, each pixel the mean of 64 samples. So the true corners are known exactly. OpenCV's convention,
# in which projectPoints and cornerSubPix work, has the middle of the first pixel at (0, 0).
# Output: interpolateCornersCharuco finds all 24 corners, on average 0.48 to 0.49 px too far right and too far down in
# both pictures. cornerSubPix, started from them, is right, to 0.00 and 0.01 px on average.
# Why it matters: errors of reprojection do not show it, as all corners are off alike: the principal point takes it up. But
# where such corners meet features, clicks or corners of a plain checkerboard, they disagree by 0.7 px.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install python3-opencv=4.6.0+dfsg-12 python3-numpy=1:1.24.2-1+deb12u1 \
  >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
export PYTHONPATH="$work/root/usr/lib/python3/dist-packages"
libraries="$work/root/usr/lib/x86_64-linux-gnu"
export LD_LIBRARY_PATH="$libraries:$libraries/blas:$libraries/lapack"
/usr/bin/python3 - <<'PY'
import sys
import cv2
import numpy as np

SQUARE, COLUMNS, ROWS, SAMPLES = 320, 7, 5, 8
WIDTH, HEIGHT = 420, 320
dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
board = cv2.aruco.CharucoBoard_create(COLUMNS, ROWS, 1.0, 0.7, dictionary)
drawing = board.draw((COLUMNS * SQUARE, ROWS * SQUARE), None, 0, 1)
# From coordinates that count from the first pixel's corner to those that count from its middle.
to_middles = np.array([[1, 0, -0.5], [0, 1, -0.5], [0, 0, 1]])
views = {"straight on": np.array([[40 / SQUARE, 0, 60], [0, 40 / SQUARE, 50], [0, 0, 1]]),
         "perspective": np.array([[0.11, 0.01, 60], [-0.008, 0.105, 60], [1e-5, 2e-5, 1]])}
same = True
for name, view in views.items():
    fine = to_middles @ np.diag([SAMPLES, SAMPLES, 1.0]) @ view @ np.linalg.inv(to_middles)
    picture = cv2.warpPerspective(drawing, fine, (WIDTH * SAMPLES, HEIGHT * SAMPLES), borderValue=255)
    picture = picture.reshape(HEIGHT, SAMPLES, WIDTH, SAMPLES).mean((1, 3)).round().astype(np.uint8)
    markers, numbers, _ = cv2.aruco.detectMarkers(picture, dictionary)
    count, corners, ids = cv2.aruco.interpolateCornersCharuco(markers, numbers, picture, board)
    places = np.array([[1 + i % (COLUMNS - 1), 1 + i // (COLUMNS - 1), 1 / SQUARE] for i in ids.ravel()]) * SQUARE
    true = places @ (to_middles @ view).T
    true = true[:, :2] / true[:, 2:]
    off = corners.reshape(-1, 2) - true
    again = cv2.cornerSubPix(picture, corners.copy(), (4, 4), (-1, -1), (3, 100, 1e-5)).reshape(-1, 2) - true
    print(f"{name}: {count} corners; interpolateCornersCharuco off by x {off[:, 0].mean():.3f}, y {off[:, 1].mean():.3f}"
          f" (least {off.min():.3f}); cornerSubPix x {again[:, 0].mean():.3f}, y {again[:, 1].mean():.3f}")
    same = same and count == 24 and (abs(off.mean(0) - 0.49) < 0.03).all() and (abs(again.mean(0)) < 0.03).all()
print("as before" if same else "CHANGED")
sys.exit(0 if same else 1)
PY
