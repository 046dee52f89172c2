#!/usr/bin/env bash
# Blender 3.4 reads its own FBX of a fractional frame rate at another speed: it places keys by the rounded rate and plays
# them at the exact one.
#
# Seen with: Debian 12's blender 3.4.1+dfsg-2+b1.
# Input: a cube that moves for 100 frames, exported to FBX by Blender at 12.5, 25, 7.5 and 24000 / 1001 frames a second
# and imported again.
# Output: at 25 the move takes 4 s, as it should. At 12.5 it takes 7.68 s in place of 8, as keys lie at twelve to the
# second; at 7.5 it takes 14.22 s in place of 13.33. Keys fall between frames. The scene's rate is right each time.
# Why it matters: 12.5 is what "on twos" at 25 is, the rate of much stop motion. No count of frames or keys and no
# setting shows the error; sound and other clips come apart from it by half a second in twelve. Written at a whole rate,
# with each picture held, the same animation comes through.
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

cat >rates.py <<'PY'
import bpy

def there_and_back(fps, base):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = fps, base
    scene.frame_start, scene.frame_end = 0, 100
    bpy.ops.mesh.primitive_cube_add()
    for frame in (0, 100):
        bpy.context.object.location.x = frame
        bpy.context.object.keyframe_insert("location", frame=frame)
    for curve in bpy.context.object.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    bpy.ops.export_scene.fbx(filepath="cube.fbx", bake_anim_simplify_factor=0)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.fbx(filepath="cube.fbx")
    render = bpy.context.scene.render
    curves = bpy.data.objects["Cube"].animation_data.action.fcurves
    keys = next(c for c in curves if c.data_path == "location" and c.array_index == 0).keyframe_points
    rate = render.fps / render.fps_base
    return rate, len(keys), (keys[-1].co[0] - keys[0].co[0]) / rate

for fps, base in ((25, 1), (25, 2), (15, 2), (24, 1.001)):
    rate, keys, seconds = there_and_back(fps, base)
    print(f"\nSEEN {fps / base:.3f} a second: {100 * base / fps:.3f} s; "
          f"read: rate {rate:.3f}, {keys} keys, {seconds:.3f} s")
PY
root/usr/bin/blender -b -t 1 --factory-startup -P rates.py >blender.log 2>&1 || true
cat >expected <<'TEXT'
SEEN 25.000 a second: 4.000 s; read: rate 25.000, 101 keys, 4.000 s
SEEN 12.500 a second: 8.000 s; read: rate 12.500, 101 keys, 7.680 s
SEEN 7.500 a second: 13.333 s; read: rate 7.500, 101 keys, 14.222 s
SEEN 23.976 a second: 4.171 s; read: rate 23.976, 101 keys, 4.175 s
TEXT
grep '^SEEN' blender.log >seen || { tail -5 blender.log; exit 2; }
cat seen
if cmp -s seen expected; then echo "as before"; else echo "CHANGED"; exit 1; fi
