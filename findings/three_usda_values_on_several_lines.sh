#!/usr/bin/env bash
# three.js refuses a USD scene whose arrays go over several lines, with a message about JSON.
#
# Seen with: npm's three 0.170.0 (USDZLoader).
# Input: a USDZ with one USDA file, a triangle, written twice: its points on one line, and one point a line, which the
# format allows as it does not count line breaks within brackets.
# Output: the first is a mesh of three vertices; the second throws "Unexpected end of JSON input" and gives no scene at
# all. The loader has no grammar: it cuts lines at "=" and hands what stands right of it to JSON.parse.
# Why it matters: a person who breaks lines of a long array for readability, or a writer of text that wraps them, makes
# files that open in other programs and not on a page. A writer for the web must keep each value on one line.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-save --ignore-scripts --prefix . three@0.170.0 >npm.log 2>&1 || { cat npm.log; exit 2; }
cat >read.mjs <<'JS'
import {USDZLoader} from "three/addons/loaders/USDZLoader.js";
import {strToU8, zipSync} from "./node_modules/three/examples/jsm/libs/fflate.module.js";

const scene = (points) => `#usda 1.0
(
    defaultPrim = "Root"
    upAxis = "Y"
)
def Xform "Root"
{
    def Mesh "Triangle"
    {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = ${points}
    }
}
`;
const read = (points) => {
  const file = zipSync({"scene.usda": [strToU8(scene(points)), {level: 0}]});
  try {
    let found = "no mesh";
    new USDZLoader().parse(file.buffer).traverse((node) => {
      if (node.isMesh) found = `a mesh of ${node.geometry.attributes.position.count} vertices`;
    });
    return found;
  } catch (error) {
    return `${error.name}: ${error.message}`;
  }
};
const one = read("[(0, 0, 0), (1, 0, 0), (0, 2, 0)]");
const several = read("[\n            (0, 0, 0),\n            (1, 0, 0),\n            (0, 2, 0)\n        ]");
console.log(`on one line:      ${one}`);
console.log(`on several lines: ${several}`);
const same = one === "a mesh of 3 vertices" && several.startsWith("SyntaxError");
console.log(same ? "as before" : "CHANGED");
process.exit(same ? 0 : 1);
JS
node read.mjs
