"""Imports a GLB into Blender and compares every frame that shows with the frames that were
exported.

    blender -b --factory-startup --python-exit-code 1 --python check_few.py -- FILE.glb TRUTH
    [PICTURE.png]

TRUTH is a folder as of WriteTruth. With PICTURE a middle frame is rendered.
"""
import json
import pathlib
import sys

import bpy
import numpy

# Debian 12 has Blender 3.4 and numpy 1.24, which lacks an alias that the glTF importer uses.
if "bool" not in vars(numpy):
    numpy.bool = bool

arguments = sys.argv[sys.argv.index("--") + 1 :]
folder = pathlib.Path(arguments[1])
truth = json.loads((folder / "truth.json").read_text())
# The truth has +y up, Blender's world +z.
points = numpy.fromfile(folder / "points.f64", "<f8").reshape(
    truth["frames"], truth["vertices"], 3
)[:, :, [0, 2, 1]] * [1, -1, 1]
faces = numpy.fromfile(folder / "faces.i32", "<i4")

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = round(truth["fps"])
bpy.ops.import_scene.gltf(filepath=arguments[0])
character = next(thing for thing in bpy.data.objects if thing.type == "MESH")
keys = character.data.shape_keys.key_blocks[1:]


def corners():
    mesh = character.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat, index = numpy.empty(3 * len(mesh.vertices), numpy.float32), numpy.empty(
        len(mesh.loops), numpy.int32
    )
    mesh.vertices.foreach_get("co", flat)
    mesh.loops.foreach_get("vertex_index", index)
    matrix = numpy.array(character.matrix_world)
    return (flat.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])[index]


def distance(frame, share=0.0):
    """To the place between a frame that shows and the next one."""
    following = min(frame + 1, truth["frames"] - 1)
    wanted = (1 - share) * points[frame][faces] + share * points[following][faces]
    return numpy.linalg.norm(corners() - wanted, axis=1).max() / truth["diagonal"]


worst, between, least, most = 0, 0, 0, 0
for i, stands in enumerate(truth["stands"]):
    scene.frame_set(i)  # the importer puts time 0 on frame 0
    worst = max(worst, distance(i))
    least, most = min(least, min(key.value for key in keys)), max(
        most, max(key.value for key in keys)
    )
    if i + 1 < truth["frames"]:
        scene.frame_set(i, subframe=0.95 if stands else 0.5)
        between = max(between, distance(i, 0 if stands else 0.5))
sliders = sum((key.slider_min, key.slider_max) == (0, 1) for key in keys)
print(f"frames={truth['frames']} targets={len(keys)} sliders={sliders}")
print(f"worst={worst} between={between} least={least} most={most}")

if len(arguments) > 2:
    scene.frame_set(truth["frames"] // 2)
    corner_places = corners()
    low, high = corner_places.min(axis=0), corner_places.max(axis=0)
    size = float(numpy.linalg.norm(high - low))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", size
    camera.location = tuple((low + high) / 2 + [0.3 * size, -2 * size, 0.3 * size])
    camera.rotation_euler = (1.42, 0, 0.15)
    camera.data.clip_end = 10 * size
    scene.collection.objects.link(camera)
    scene.camera = camera
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 4, (0.8, 0.2, 0.4)
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("world")
    scene.render.engine, scene.cycles.samples = "CYCLES", 32
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.filepath = (
        640,
        640,
        arguments[2],
    )
    bpy.ops.render.render(write_still=True)
