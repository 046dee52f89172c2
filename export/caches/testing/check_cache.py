"""Imports the mesh of a point cache into Blender, binds the cache to it, and compares every frame.

    blender -b --factory-startup --python-exit-code 1 --python check_cache.py -- CACHE TRUTH
    [IMPORTER] [PICTURE.png FRAME]

CACHE is a .pc2 or .mdd file beside its .obj. TRUTH is a folder that WriteTruth made. IMPORTER is
`new` (File > Import > Wavefront, Blender 3.3 and later) or `legacy`. All settings, of the importer
and of the Mesh Cache modifier, stay as they are. Prints
error_over_diagonal=NUMBER.
"""
import json
import os
import sys

import bpy
import mathutils
import numpy

arguments = sys.argv[sys.argv.index("--") + 1 :]
cache, truth_folder = arguments[:2]
importer = arguments[2] if len(arguments) > 2 else "new"


def import_mesh(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if importer == "legacy":
        bpy.ops.import_scene.obj(filepath=path)
    else:
        bpy.ops.wm.obj_import(filepath=path)
    meshes = [o for o in bpy.data.objects if o.type == "MESH"]
    if len(meshes) != 1:
        sys.exit(f"expected one mesh, found {len(meshes)}")
    return meshes[0]


def bind(character):
    modifier = character.modifiers.new("cache", "MESH_CACHE")
    modifier.cache_format = "PC2" if cache.endswith(".pc2") else "MDD"
    modifier.filepath = cache


def points_at(character, frame):
    """V x 3 in Blender's world, whose +z points up."""
    bpy.context.scene.frame_set(frame)
    evaluated = character.evaluated_get(bpy.context.evaluated_depsgraph_get())
    vertices = evaluated.data.vertices
    points = numpy.empty(3 * len(vertices), dtype=numpy.float32)
    vertices.foreach_get("co", points)
    matrix = numpy.array(character.matrix_world, dtype=numpy.float64)
    return points.reshape(-1, 3).astype(numpy.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def compare(character):
    with open(os.path.join(truth_folder, "truth.json")) as file:
        truth = json.load(file)
    with_y_up = numpy.fromfile(os.path.join(truth_folder, "points.f64")).reshape(
        truth["frames"], -1, 3
    )
    expected = numpy.stack([with_y_up[..., 0], -with_y_up[..., 2], with_y_up[..., 1]], axis=-1)
    error, moved = 0, 0
    for frame in range(truth["frames"]):
        found = points_at(character, frame)
        if found.shape != expected[frame].shape:
            sys.exit(f"expected {len(expected[frame])} vertices, found {len(found)}")
        error = max(error, numpy.linalg.norm(found - expected[frame], axis=1).max())
        moved = max(moved, numpy.linalg.norm(found - expected[0], axis=1).max())
    print(f"frames={truth['frames']} moved_over_diagonal={moved / truth['diagonal']:.3g}")
    print(f"error_over_diagonal={error / truth['diagonal']:.3g}")


def check_faces(character):
    faces = numpy.fromfile(os.path.join(truth_folder, "faces.i32"), dtype=numpy.int32).reshape(
        -1, 3
    )
    found = numpy.array([polygon.vertices[:] for polygon in character.data.polygons])
    if not numpy.array_equal(found, faces):
        sys.exit("the faces differ")
    corners = numpy.fromfile(os.path.join(truth_folder, "corner_uvs.f64")).reshape(-1, 2)
    if len(corners):
        uvs = numpy.array([loop.uv[:] for loop in character.data.uv_layers.active.data])
        print(f"uv_error={numpy.abs(uvs - corners).max():.3g}")


def draw(character, path, frame):
    bpy.context.scene.frame_set(frame)
    scene = bpy.context.scene
    corners = [character.matrix_world @ mathutils.Vector(corner) for corner in character.bound_box]
    center = (corners[0] + corners[6]) / 2
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = center + 1.6 * (corners[6] - corners[0]).length * mathutils.Vector(
        (0.5, -1, 0.35)
    )
    camera.data.clip_start = (corners[6] - corners[0]).length / 100
    camera.rotation_euler = (center - camera.location).to_track_quat("-Z", "Y").to_euler()
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "SUN"))
    lamp.rotation_euler = (0.6, 0.4, 0)
    lamp.data.energy = 3
    for item in (camera, lamp):
        scene.collection.objects.link(item)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
    scene.render.resolution_x, scene.render.resolution_y = 480, 480
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (0.4, 0.4, 0.4)
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


mesh = import_mesh(os.path.splitext(cache)[0] + ".obj")
check_faces(mesh)
bind(mesh)
compare(mesh)
if len(arguments) > 4:
    draw(mesh, arguments[3], int(arguments[4]))
