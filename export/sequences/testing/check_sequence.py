"""Imports a numbered sequence into Blender with the importers' default settings and compares all
frames.

    blender -b --factory-startup --python-exit-code 1 --python check_sequence.py -- TRUTH FOLDER
    obj|ply

TRUTH is a folder as of WriteTruth. Files are found and ordered as the add-on Stop-motion-OBJ does:
all that begin with "frame", by the numbers in their names.
"""
import json
import pathlib
import re
import sys

import bpy
import numpy

truth_folder, folder, kind = sys.argv[sys.argv.index("--") + 1 :]
truth = json.loads((pathlib.Path(truth_folder) / "truth.json").read_text())


def raw(name, kind_of_number):
    return numpy.fromfile(pathlib.Path(truth_folder) / name, kind_of_number)


# The truth has +y up, Blender's world +z.
points = raw("points.f64", "<f8").reshape(truth["frames"], truth["vertices"], 3)[
    :, :, [0, 2, 1]
] * [1, -1, 1]
faces = raw("faces.i32", "<i4").reshape(-1, 3)
corner_uvs = raw("corner_uvs.f64", "<f8").reshape(-1, 2)


def by_numbers(path):
    return [int(part) if part.isdigit() else part for part in re.split("([0-9]+)", path.name)]


def imported(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if kind == "obj":
        bpy.ops.wm.obj_import(filepath=str(path))
    else:
        bpy.ops.import_mesh.ply(filepath=str(path))
    meshes = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    assert len(meshes) == 1, f"{len(meshes)} meshes in {path}"
    return meshes[0]


files = sorted(pathlib.Path(folder).glob(f"frame*.{kind}"), key=by_numbers)
worst, worst_uv, textures, smooth = 0, 0, 0, 0
for i, path in enumerate(files):
    thing = imported(path)
    mesh = thing.data
    flat = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", flat)
    matrix = numpy.array(thing.matrix_world)
    found = flat.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    corners = numpy.array([tuple(face.vertices) for face in mesh.polygons])
    assert (corners == faces).all(), f"other faces in {path}"
    worst = max(worst, numpy.linalg.norm(found - points[i], axis=1).max() / truth["diagonal"])
    smooth += all(face.use_smooth for face in mesh.polygons)
    if kind == "obj" and len(corner_uvs):
        uvs = numpy.array([tuple(loop.uv) for loop in mesh.uv_layers[0].data])
        worst_uv = max(worst_uv, abs(uvs - corner_uvs).max())
        nodes = [
            node
            for slot in mesh.materials
            for node in slot.node_tree.nodes
            if node.type == "TEX_IMAGE"
        ]
        textures += any(node.image and node.image.size[0] > 0 for node in nodes)
print(f"files={len(files)} worst={worst} uv={worst_uv} textures={textures} smooth={smooth}")
