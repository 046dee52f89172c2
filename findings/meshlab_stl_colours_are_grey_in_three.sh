#!/usr/bin/env bash
# A coloured STL from MeshLab is grey in three.js: MeshLab writes Magics' header and the opposite of Magics' bit.
#
# Seen with: Debian 12's meshlab 2020.09+dfsg1-2, npm's three 0.170.0 (STLLoader).
# Input: a PLY of four triangles, red, green, blue and yellow, saved by meshlabserver as STL with colours of faces.
# Output: the header has COLOR= with a grey. By Magics' rule the highest bit of a face's 16 says "as the header", and a clear
# one "its own colour"; MeshLab sets it on all four, with their colours in the other 15. STLLoader follows the rule: four
# times the header's grey. With the bit cleared, the same file has the four colours.
# Why it matters: printing services and web pages show the model without its paint, and neither program says a word. A
# reader can tell: where every face has the bit set and some have colours, these are meant.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install meshlab=2020.09+dfsg1-2 xvfb xauth >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
npm install --silent --no-save --ignore-scripts --prefix . three@0.170.0 >npm.log 2>&1 || { cat npm.log; exit 2; }
libraries="$work/root/usr/lib/x86_64-linux-gnu"
export PATH="$work/root/usr/bin:$PATH" LD_LIBRARY_PATH="$libraries:$libraries/meshlab"

printf '%s\n' ply "format ascii 1.0" "element vertex 4" "property float x" "property float y" "property float z" \
  "element face 4" "property list uchar int vertex_indices" "property uchar red" "property uchar green" \
  "property uchar blue" "property uchar alpha" end_header "0 0 0" "1 0 0" "0 1 0" "0 0 1" "3 0 2 1 255 0 0 255" \
  "3 0 1 3 0 255 0 255" "3 1 2 3 0 0 255 255" "3 2 0 3 255 255 0 255" >painted.ply
xvfb-run -a meshlabserver -i painted.ply -o painted.stl -m fc >meshlab.log 2>&1 || { cat meshlab.log; exit 2; }
cat >read.mjs <<'JS'
import {readFileSync} from "node:fs";
import {STLLoader} from "three/addons/loaders/STLLoader.js";

const file = readFileSync("painted.stl");
const faces = file.readUInt32LE(80);
const at = (f) => 84 + 50 * f + 48;
const bits = Array.from({length: faces}, (_, f) => file.readUInt16LE(at(f)));
const shown = (bytes) => {
  const {color} = new STLLoader().parse(new Uint8Array(bytes).buffer).attributes;
  return Array.from({length: faces}, (_, f) =>
    [0, 1, 2].map((k) => (color.array[9 * f + k] > 0.6 ? 1 : color.array[9 * f + k] > 0.1 ? "?" : 0)).join("")).join(" ");
};
console.log(`as written: ${bits.map((one) => one.toString(16)).join(" ")}; shown: ${shown(file)}`);
for (let f = 0; f < faces; ++f) file.writeUInt16LE(bits[f] & 0x7fff, at(f));
console.log(`with the bit cleared, shown: ${shown(file)}`);
JS
result=$(node read.mjs)
echo "$result"
if [ "$result" = "as written: 801f 83e0 fc00 83ff; shown: ??? ??? ??? ???
with the bit cleared, shown: 100 010 001 110" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
