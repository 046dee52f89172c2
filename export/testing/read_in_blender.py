"""Imports one format into Blender and compares every frame that shows with the frames that were
exported.

    blender -b --factory-startup --python-exit-code 1 --python read_in_blender.py -- FORMAT FILE
    TRUTH RESULT

FILE is what a person opens, or the animation's folder; TRUTH the file that formats_test.py wrote:
positions of every frame that shows, with z up. RESULT is JSON: frames, worst (largest distance of a
corner, over the diagonal), uv (largest difference of a texture coordinate), and what else the
program found.

Corner k of face f in Blender is compared with corner k of face f of the frames: all formats keep
the order of the faces. Where a format has texture coordinates, those of all corners must agree, or
the order is not what it seems.
"""
import json
import pathlib
import sys

import bpy
import numpy

# Debian 12 has Blender 3.4 and numpy 1.24, which lacks an alias that the glTF importer uses.
if "bool" not in vars(numpy):
    numpy.bool = bool

FORMAT, FILE, TRUTH, RESULT = sys.argv[sys.argv.index("--") + 1 :]
opened = pathlib.Path(FILE)
truth = dict(numpy.load(TRUTH))
fps, shown, corners = float(truth["fps"]), truth["shown"], truth["faces"].reshape(-1)
diagonal = float(truth["diagonal"])
scene = bpy.context.scene


def character():
    meshes = [obj for obj in bpy.data.objects if obj.type == "MESH"]
    if len(meshes) != 1:
        raise SystemExit(f"expected one mesh, found {len(meshes)}")
    return meshes[0]


def corner_positions(obj):
    """Where Blender shows each corner of each face, with the object's own axes and unit applied."""
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", points)
    indices = numpy.empty(len(mesh.loops), numpy.int32)
    mesh.loops.foreach_get("vertex_index", indices)
    matrix = numpy.array(obj.matrix_world)
    world = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    if len(indices) != len(corners):
        raise SystemExit(f"{len(indices)} corners, but the frames have {len(corners)}")
    return world[indices]


def distance(obj, points):
    return float(
        numpy.linalg.norm(corner_positions(obj) - points[corners], axis=1).max() / diagonal
    )


def uv_difference(mesh):
    if not mesh.uv_layers:
        return None
    uvs = numpy.empty(2 * len(mesh.loops), numpy.float32)
    mesh.uv_layers[0].data.foreach_get("uv", uvs)
    return float(abs(uvs.reshape(-1, 2) - truth["uvs"]).max())


def playback(obj, first_frame):
    """Every frame that shows, when the scene plays from first_frame on."""
    worst = 0
    for i, points in enumerate(shown):
        at = first_frame + i * (scene.render.fps / scene.render.fps_base) / fps
        scene.frame_set(int(at + 1e-6), subframe=max(0.0, at - int(at + 1e-6)))
        worst = max(worst, distance(obj, points))
    return {
        "frames": len(shown),
        "worst": worst,
        "uv": uv_difference(obj.data),
        "texture": shows_texture(obj.data),
    }


def shows_texture(mesh):
    nodes = [
        node
        for material in mesh.materials
        if material and material.node_tree
        for node in material.node_tree.nodes
    ]
    return any(node.type == "TEX_IMAGE" and node.image and node.image.size[0] > 0 for node in nodes)


def play_shape_keys(obj):
    """The importer may keep the animation in a track of the NLA editor, and plays it from there."""
    data = obj.data.shape_keys.animation_data
    if data.action is None:
        data.action = data.nla_tracks[0].strips[0].action
        for track in data.nla_tracks:
            track.mute = True


def last_key(obj, first_frame):
    """The time of the last keyframe, in frames of the animation."""
    action = obj.data.shape_keys.animation_data.action
    return (action.frame_range[1] - first_frame) / (scene.render.fps / scene.render.fps_base) * fps


def gltf():
    scene.render.fps = round(fps)
    bpy.ops.import_scene.gltf(filepath=FILE)
    play_shape_keys(character())
    return {**playback(character(), 0), "last": last_key(character(), 0)}


def fbx():
    scene.render.fps = 7  # the importer sets that of the file
    bpy.ops.import_scene.fbx(filepath=FILE)
    result = playback(character(), 1)  # the importer's "Animation Offset" is 1
    result.update(fps=scene.render.fps / scene.render.fps_base, last=last_key(character(), 1))
    return result


def cache():
    """The mesh beside the cache by the importer's own settings; a Mesh Cache modifier that is only
    given the file."""
    bpy.ops.wm.obj_import(filepath=str(opened.with_suffix(".obj")))
    scene.render.fps = round(fps)
    modifier = character().modifiers.new("cache", "MESH_CACHE")
    modifier.cache_format = FORMAT.upper()
    modifier.filepath = FILE
    result = playback(character(), 0)
    # Blender does not tell how many samples it found. Both formats say it in their heads.
    at, kind = {"PC2": (28, "<i4"), "MDD": (0, ">i4")}[modifier.cache_format]
    result["frames"] = int(numpy.fromfile(FILE, kind, 1, offset=at)[0])
    return result


def sequence(read):
    """One file for each frame that shows."""
    files = sorted(folder().glob(f"{FORMAT}/*.{FORMAT}"))
    if len(files) != len(shown):
        raise SystemExit(f"{len(files)} files, but {len(shown)} frames show")
    worst, uv, texture = 0, 0, True
    for file, points in zip(files, shown):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        read(str(file))
        worst = max(worst, distance(character(), points))
        difference = uv_difference(character().data)
        uv = None if difference is None else max(uv, difference)
        texture = texture and shows_texture(character().data)
    return {"frames": len(files), "worst": worst, "uv": uv, "texture": texture}


def read_obj(path):
    bpy.ops.wm.obj_import(filepath=path)


def read_ply(path):
    bpy.ops.import_mesh.ply(filepath=path)


def add_on():
    sys.path.insert(0, str(folder() / "blender"))
    import keypose_import

    keypose_import.register()
    scene.render.fps = 7
    bpy.ops.import_scene.keypose(directory=str(folder()))
    group = character().data["keypose_textures"]
    result = playback(character(), 1)
    result["fps"] = scene.render.fps / scene.render.fps_base
    result["texture"] = all(
        node.image.size[0] > 0 for node in group.nodes if node.type == "TEX_IMAGE"
    )
    result["markers"] = [[marker.name, marker.frame - 1] for marker in scene.timeline_markers]
    if scene.frame_end - scene.frame_start + 1 != len(shown):
        raise SystemExit(
            f"the scene shows {scene.frame_start} to {scene.frame_end}, not {len(shown)} frames"
        )
    return result


def folder():
    """Of the whole animation."""
    return next(
        place for place in [opened, *opened.parents] if (place / "animation.json").is_file()
    )


def film():
    clip = bpy.data.movieclips.load(FILE)
    return {
        "frames": clip.frame_duration,
        "fps": clip.fps,
        "seconds": {opened.name: clip.frame_duration / clip.fps},
    }


READERS = {
    "glb": gltf,
    "glb-full": gltf,
    "glb-few": gltf,
    "fbx": fbx,
    "pc2": cache,
    "mdd": cache,
    "obj": lambda: sequence(read_obj),
    "ply": lambda: sequence(read_ply),
    "blender": add_on,
    "video": film,
}

for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
pathlib.Path(RESULT).write_text(json.dumps(READERS[FORMAT]()))
