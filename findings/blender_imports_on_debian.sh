#!/usr/bin/env bash
# Debian 12's Blender imports no BVH at all, and no glTF with default settings: its add-ons meet a newer Python and a
# newer numpy than they were written for.
#
# Seen with: Debian 12's blender 3.4.1+dfsg-2+b1 with its Python 3.11.2 and python3-numpy 1:1.24.2-1+deb12u1.
# Input: a BVH of one joint, and a glTF of one triangle with positions only.
# Output: import_anim.bvh ends with "invalid mode: 'rU'", an open mode that Python dropped in 3.11. import_scene.gltf ends
# with "module 'numpy' has no attribute 'bool'", an alias that numpy dropped in 1.24. The glTF opens once shading is
# set to Flat.
# Why it matters: whoever checks files with the Blender that a distribution packs takes an error for a fault of the file.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install blender=3.4.1+dfsg-2+b1 blender-data=3.4.1+dfsg-2 \
  python3-numpy=1:1.24.2-1+deb12u1 >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
libraries="$work/root/usr/lib/x86_64-linux-gnu"
export LD_LIBRARY_PATH="$libraries:$libraries/blas:$libraries/lapack"
export PYTHONPATH="$work/root/usr/lib/python3/dist-packages"
export BLENDER_SYSTEM_SCRIPTS="$work/root/usr/share/blender/scripts"
export BLENDER_SYSTEM_DATAFILES="$work/root/usr/share/blender/datafiles"

cat >clip.bvh <<'BVH'
HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  End Site
  {
    OFFSET 0 1 0
  }
}
MOTION
Frames: 2
Frame Time: 0.04
0 0 0 0 0 0
0 1 0 10 0 0
BVH
cat >try.py <<'PY'
import base64, json, struct
import bpy

points = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36,
                 "uri": "data:application/octet-stream;base64," + base64.b64encode(points).decode()}]},
    open("triangle.gltf", "w"))

def attempt(what, importer, **options):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    try:
        importer(**options)
        print(f"\nSEEN {what}: fine")
    except Exception as error:
        text = str(error)
        known = [part for part in ("invalid mode: 'rU'", "module 'numpy' has no attribute 'bool'") if part in text]
        print(f"\nSEEN {what}:", known[0] if known else text)

attempt("BVH", bpy.ops.import_anim.bvh, filepath="clip.bvh")
attempt("glTF", bpy.ops.import_scene.gltf, filepath="triangle.gltf")
attempt("glTF, shading flat", bpy.ops.import_scene.gltf, filepath="triangle.gltf", import_shading="FLAT")
PY
root/usr/bin/blender -b -t 1 --factory-startup -P try.py >blender.log 2>&1 || true
cat >expected <<'TEXT'
SEEN BVH: invalid mode: 'rU'
SEEN glTF: module 'numpy' has no attribute 'bool'
SEEN glTF, shading flat: fine
TEXT
grep '^SEEN' blender.log >seen || { tail -5 blender.log; exit 2; }
cat seen
if cmp -s seen expected; then echo "as before"; else echo "CHANGED"; exit 1; fi
