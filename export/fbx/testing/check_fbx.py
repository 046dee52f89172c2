"""Imports an FBX file into Blender with the default settings and compares all of it with the truth.

    blender -b --factory-startup --python-exit-code 1 --python check_fbx.py -- FILE.fbx TRUTH STANDS
    [PICTURE.png FRAME]

TRUTH is a folder that WriteTruth made. STANDS has a 1 for each shown frame that is held until the
next, else 0; no character for the last. Prints figures as name=NUMBER, and the names of the shape
keys as shape_keys=A,B,...
"""
import json
import os
import sys

import bpy
import numpy

arguments = sys.argv[sys.argv.index("--") + 1 :]
path, truth_folder, stands = arguments[:3]


def raw(name, kind, columns):
    return numpy.fromfile(os.path.join(truth_folder, name), dtype=kind).reshape(-1, columns)


def with_z_up(rows):
    return numpy.stack([rows[..., 0], -rows[..., 2], rows[..., 1]], axis=-1)


def import_mesh():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.fbx(filepath=path)
    meshes = [o for o in bpy.data.objects if o.type == "MESH"]
    if len(bpy.data.objects) != 1 or len(meshes) != 1:
        sys.exit(f"expected one mesh and nothing else, found {len(bpy.data.objects)} objects")
    return meshes[0]


def points_at(character, frame, subframe=0.0):
    """V x 3 in Blender's world. The importer puts time 0 on frame 1."""
    bpy.context.scene.frame_set(1 + frame, subframe=subframe)
    evaluated = character.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = numpy.empty(3 * len(evaluated.data.vertices), dtype=numpy.float32)
    evaluated.data.vertices.foreach_get("co", points)
    matrix = numpy.array(character.matrix_world, dtype=numpy.float64)
    return points.reshape(-1, 3).astype(numpy.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def farthest(a, b):
    if a.shape != b.shape:
        sys.exit(f"expected {len(b)} vertices, found {len(a)}")
    return numpy.linalg.norm(a - b, axis=1).max()


def compare_frames(character, truth):
    expected = with_z_up(raw("points.f64", numpy.float64, 3).reshape(truth["frames"], -1, 3))
    error, moved, between = 0, 0, 0
    for frame in range(truth["frames"]):
        found = points_at(character, frame)
        error = max(error, farthest(found, expected[frame]))
        moved = max(moved, farthest(found, expected[0]))
        if frame + 1 < truth["frames"]:
            goal = (
                expected[frame]
                if stands[frame] == "1"
                else (expected[frame] + expected[frame + 1]) / 2
            )
            between = max(between, farthest(points_at(character, frame, 0.5), goal))
    print(f"frames={truth['frames']} moved_over_diagonal={moved / truth['diagonal']:.3g}")
    print(
        f"error_over_diagonal={error / truth['diagonal']:.3g} "
        f"between_over_diagonal={between / truth['diagonal']:.3g}"
    )


def compare_corners(character, truth):
    mesh = character.data
    faces = raw("faces.i32", numpy.int32, 3)
    if not numpy.array_equal(
        numpy.array([polygon.vertices[:] for polygon in mesh.polygons]), faces
    ):
        sys.exit("the faces differ")
    normals = numpy.zeros((truth["vertices"], 3))
    normals[raw("split_source.i32", numpy.int32, 1)[:, 0]] = with_z_up(
        raw("split_normals.f64", numpy.float64, 3)[: truth["split_vertices"]]
    )
    mesh.calc_normals_split()
    turn = numpy.array(character.matrix_world)[:3, :3]
    found = numpy.array([loop.normal[:] for loop in mesh.loops]) @ turn.T
    print(
        f"normal_error={numpy.abs(found - normals[faces.ravel()]).max():.3g} "
        f"smooth={mesh.polygons[0].use_smooth:d}"
    )
    uvs = raw("corner_uvs.f64", numpy.float64, 2)
    print(f"uv_layers={len(mesh.uv_layers)}")
    if len(uvs):
        found = numpy.array([loop.uv[:] for loop in mesh.uv_layers[0].data])
        print(f"uv_error={numpy.abs(found - uvs).max():.3g}")


def tell(character):
    render = bpy.context.scene.render
    print(
        f"fps={render.fps / render.fps_base:.9g} "
        f"scale={max(abs(s - 1) for s in character.scale):.3g}"
    )
    print(
        f"object={character.name} mesh={character.data.name} "
        f"materials={','.join(m.name for m in character.data.materials)}"
    )
    keys = character.data.shape_keys
    print(f"shape_keys={','.join(block.name for block in keys.key_blocks[1:]) if keys else ''}")
    print(f"actions={','.join(action.name for action in bpy.data.actions)}")
    material = character.data.materials[0]
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    print(
        f"roughness={shader.inputs['Roughness'].default_value:.3g} "
        f"alpha={shader.inputs['Alpha'].default_value:.3g}"
    )
    links = shader.inputs["Base Color"].links
    images = [link.from_node.image for link in links if link.from_node.type == "TEX_IMAGE"]
    print(f"images={len(bpy.data.images)} shown={len(images)}")
    for image in images:
        pixels = numpy.array(image.pixels[:]).reshape(image.size[1], image.size[0], -1)
        print(
            f"image={image.name} packed={image.packed_file is not None:d} width={image.size[0]} "
            f"height={image.size[1]} "
            f"lower_left={','.join(str(round(255 * c)) for c in pixels[0, 0, :3])} "
            f"upper_right={','.join(str(round(255 * c)) for c in pixels[-1, -1, :3])}"
        )


def draw(character, picture, frame):
    scene = bpy.context.scene
    points = points_at(character, frame)
    low, high = points.min(axis=0), points.max(axis=0)
    center, size = (low + high) / 2, (high - low).max()
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = center + 2.2 * size * numpy.array([0.5, -1, 0.35])
    camera.rotation_euler = (
        (camera.location - type(camera.location)(center)).to_track_quat("Z", "Y").to_euler()
    )
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "SUN"))
    lamp.rotation_euler, lamp.data.energy = (0.6, 0.4, 0), 3
    for item in (camera, lamp):
        scene.collection.objects.link(item)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
    scene.render.resolution_x, scene.render.resolution_y = 480, 480
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (0.4, 0.4, 0.4)
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


with open(os.path.join(truth_folder, "truth.json")) as file:
    the_truth = json.load(file)
the_character = import_mesh()
tell(the_character)
compare_frames(the_character, the_truth)
compare_corners(the_character, the_truth)
if len(arguments) > 4:
    draw(the_character, arguments[3], int(arguments[4]))
