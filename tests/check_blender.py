"""Imports a GLB into Blender and checks what an animator finds there.

    blender -b --factory-startup --python-exit-code 1 --python tests/check_blender.py -- FILE.glb SHAPE_KEYS
            [VERTICES] [TEXTURE_WIDTH] [STEPS]

SHAPE_KEYS is the number of morph targets, without the basis. TEXTURE_WIDTH 0 means that there must be no texture.
STEPS has one character per frame at 24 frames per second: 1 if the picture must be held until the next frame,
else 0.
"""
import sys

import bpy
import numpy

# Debian 12 has Blender 3.4 and numpy 1.24. This numpy lacks an alias that the glTF importer uses for every file.
if "bool" not in vars(numpy):
    numpy.bool = bool

arguments = sys.argv[sys.argv.index("--") + 1:]
path, expected_keys = arguments[0], int(arguments[1])
expected_vertices = int(arguments[2]) if len(arguments) > 2 else None
expected_width = int(arguments[3]) if len(arguments) > 3 else None
expected_steps = arguments[4] if len(arguments) > 4 else ""


def require(condition, message):
    if not condition:
        print("check_blender: " + message, file=sys.stderr)
        sys.exit(1)


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=path)
meshes = [o for o in bpy.data.objects if o.type == "MESH"]
require(len(meshes) == 1, f"expected one mesh, found {len(meshes)}")
character = meshes[0]
if expected_vertices is not None:
    found = len(character.data.vertices)
    require(found == expected_vertices, f"expected {expected_vertices} vertices, found {found}")

keys = character.data.shape_keys
found = len(keys.key_blocks) - 1 if keys else 0
require(found == expected_keys, f"expected {expected_keys} shape keys, found {found}")
if expected_keys > 0:
    action = keys.animation_data.action if keys.animation_data else None
    # The importer may stash the action in an NLA track.
    tracks = keys.animation_data.nla_tracks if keys.animation_data else []
    require(action or any(strip.action for track in tracks for strip in track.strips), "the shape keys have no action")
    action = action or next(strip.action for track in tracks for strip in track.strips if strip.action)
    require(len(action.fcurves) == expected_keys, f"expected {expected_keys} curves, found {len(action.fcurves)}")
    for i, curve in enumerate(action.fcurves):
        top = max(point.co[1] for point in curve.keyframe_points)
        require(abs(top - 1) < 1e-6, f"curve {i} never reaches 1 (its top is {top})")
    # The importer puts time 0 on frame 0.
    for frame, stands in enumerate(expected_steps):
        for curve in action.fcurves:
            here, later = curve.evaluate(frame + 0.002), curve.evaluate(frame + 0.9)
            require(stands == "0" or abs(here - later) < 1e-3, f"{curve.array_index}: glides from {here} to {later} after frame {frame}")
    names = [block.name for block in keys.key_blocks][1:]
    require(names[0].startswith(("frame_000", "shape_1")), f"the first shape key is called {names[0]}")
    moved = max((a.co - b.co).length for a, b in zip(keys.key_blocks[0].data, keys.key_blocks[-1].data))
    require(moved > 0, "the last shape key moves nothing")

if expected_width is not None:
    images = [i for i in bpy.data.images if i.size[0] > 0 and i.type == "IMAGE"]
    if expected_width == 0:
        require(not images, f"expected no texture, found {len(images)}")
    else:
        require(len(images) == 1, f"expected one texture, found {len(images)}")
        require(images[0].size[0] == expected_width, f"expected a texture {expected_width} wide, found {images[0].size[0]}")
        nodes = [n for m in character.data.materials for n in m.node_tree.nodes if n.type == "TEX_IMAGE" and n.image == images[0]]
        require(nodes and nodes[0].outputs["Color"].links, "the material does not show the texture")
    require(len(character.data.uv_layers) == (1 if expected_width else 0), "wrong number of UV layers")
print(f"check_blender: {len(character.data.vertices)} vertices, {expected_keys} shape keys, an action and the texture as expected")
