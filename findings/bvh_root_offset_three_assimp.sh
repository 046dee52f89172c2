#!/usr/bin/env bash
# three.js adds a BVH joint's OFFSET to its position channels, Assimp replaces the one by the other: the same clip stands
# at twice the height in one of them.
#
# Seen with: npm's three 0.170.0 (BVHLoader) and Debian 12's assimp-utils 5.2.5~ds0-1+b1.
# Input: a BVH whose root has OFFSET 0 90 0 and position channels that say 0 90 0 in the first frame and 0 100 0 in the
# second, and whose other joint, with six channels as motion capture suits write them, repeats its OFFSET 0 20 0 in its
# channels. The channels hold places, as in files that most programs write.
# Output: root at height 180 and 190 and the joint 40 above it in three.js; 90 and 100, and 20 above it, in Assimp.
# Why it matters: the format's description does not say whether the channels replace the offset. With a root at the origin
# and three channels for the rest, as in most samples, both agree; then a clip of another studio floats in the air
# and has stretched limbs, and which reader is wrong cannot be told from the file.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install assimp-utils=5.2.5~ds0-1+b1 libassimp5=5.2.5~ds0-1+b1 \
  >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
npm install --silent --no-save --ignore-scripts --prefix . three@0.170.0 >npm.log 2>&1 || { cat npm.log; exit 2; }
cat >clip.bvh <<'BVH'
HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0 20 0
    CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 30 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.04
0 90 0 0 0 0 0 20 0 0 0 0
0 100 0 0 0 0 0 20 0 0 0 0
BVH
cat >read.mjs <<'JS'
import {readFileSync} from "node:fs";
import {BVHLoader} from "three/addons/loaders/BVHLoader.js";

const {clip} = new BVHLoader().parse(readFileSync("clip.bvh", "utf8"));
const heights = (name) => {
  const {values} = clip.tracks.find((track) => track.name === `${name}.position`);
  return [values[1], values[4]];
};
console.log("Hips", ...heights("Hips"), "Spine", ...heights("Spine"));
JS
by_three=$(node read.mjs)
LD_LIBRARY_PATH="$work/root/usr/lib/x86_64-linux-gnu" root/usr/bin/assimp dump clip.bvh clip.xml >assimp.log 2>&1
by_assimp=$(python3 - <<'PY'
import re

text = open("clip.xml").read()
found = []
for name in ("Hips", "Spine"):
    keys = text.split(f'<NodeAnim node="{name}">')[1].split("</PositionKeyList>")[0]
    places = re.findall(r'<PositionKey time="[^"]*">\s*([-\d.e+]+)\s+([-\d.e+]+)', keys)
    found += [name] + [f"{float(y):g}" for _, y in places]
print(*found)
PY
)
echo "heights in both frames, in the file: Hips 90 100 Spine 20 20"
echo "three.js: $by_three"
echo "Assimp:   $by_assimp"
if [ "$by_three" = "Hips 180 190 Spine 40 40" ] && [ "$by_assimp" = "Hips 90 100 Spine 20 20" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
