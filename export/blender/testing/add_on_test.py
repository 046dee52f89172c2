"""Installs the add-on in Blender as an artist does, imports a project, works on it, and updates.

    BLENDER_USER_SCRIPTS=TEMPORARY blender -b --factory-startup --python-exit-code 1 --python
    add_on_test.py -- FOLDER

FOLDER holds the projects that blender_files_test writes: `first`; `second` with other shapes and
textures; `other_faces` with another number of faces, held ends and a way back; `y_up`. Each has its
frames as PLY, one for each frame that is shown. A vertex may be 1e-5 of the diagonal away.
"""
import os
import pathlib
import shutil
import sys
import types

import bpy
import numpy

folder = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
project = folder / "project"
TOLERANCE = 1e-5
checks = 0


def require(condition, message):
    global checks
    checks += 1
    if not condition:
        raise SystemExit(f"add_on_test: {message}\n")


def read_ply(path):
    """Positions of one of Keypose's PLY files."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    count = next(
        int(line.split()[2])
        for line in head.decode().splitlines()
        if line.startswith("element vertex")
    )
    stride = 8 * head.split(b"element face")[0].count(b"property double")
    rows = numpy.frombuffer(body[: stride * count], "<f8").reshape(count, -1)
    return rows[:, :3]


def shown_frames(name):
    return [read_ply(path) for path in sorted((folder / name / "out/animation/ply").glob("*.ply"))]


def run_project(name):
    """What `keypose run` leaves: the results of another run in the same place."""
    shutil.rmtree(project, ignore_errors=True)
    shutil.copytree(folder / name, project)


def evaluated(obj, frame, subframe=0.0):
    bpy.context.scene.frame_set(frame, subframe=subframe)
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(float)


def worst_error(obj, frames, start):
    diagonal = numpy.linalg.norm(numpy.ptp(frames[0], axis=0))
    return (
        max(abs(evaluated(obj, start + i) - points).max() for i, points in enumerate(frames))
        / diagonal
    )


def refused(operator, part, **arguments):
    try:
        operator(**arguments)
    except RuntimeError as error:
        require(part in str(error), f"expected an error with '{part}', got: {error}")
        return
    require(False, f"no error; expected one with '{part}'")


def mean_color(obj, frame):
    """The textures' weighted sum, by the values that Blender's drivers set."""
    bpy.context.scene.frame_set(frame)
    group = obj.data["keypose_textures"].evaluated_get(bpy.context.evaluated_depsgraph_get())
    color = numpy.zeros(3)
    for i in range(sum(node.type == "TEX_IMAGE" for node in group.nodes)):
        pixels = numpy.array(
            obj.data["keypose_textures"].nodes[f"texture {i}"].image.pixels[:]
        ).reshape(-1, 4)
        color += group.nodes[f"weight {i}"].inputs[0].default_value * pixels.mean(axis=0)[:3]
    return color


def install():
    run_project("first")
    add_on = project / "out/animation/blender/keypose_import.py"
    bpy.ops.preferences.addon_install(filepath=str(add_on))
    bpy.ops.preferences.addon_enable(module="keypose_import")
    info = __import__("keypose_import").bl_info
    require(
        info["blender"] == (3, 4, 0) and info["category"] == "Import-Export",
        "bl_info is not complete",
    )
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.preferences.addon_enable(module="keypose_import")


def check_errors():
    bare = folder / "bare"
    (bare / "fresh").mkdir(parents=True)
    (bare / "fresh/pipeline.yaml").write_text("poses: {}\n")
    shutil.copytree(folder / "first", bare / "others")
    shutil.rmtree(bare / "others/out/animation/blender")
    shutil.copytree(folder / "first", bare / "cut")
    cache = bare / "cut/out/animation/blender/character.pc2"
    cache.write_bytes(cache.read_bytes()[:-1])
    shutil.copytree(folder / "first", bare / "newer")
    told = bare / "newer/out/animation/blender/character.json"
    told.write_text(told.read_text().replace('"schema": 1', '"schema": 2'))
    shutil.copytree(folder / "first", bare / "broken")
    (bare / "broken/out/animation/blender/character.json").write_text("{")
    for name, part in [
        ("", "is not a Keypose project"),
        ("nowhere", "There is no folder"),
        ("fresh", "keypose run"),
        ("others", "export.formats"),
        ("cut", "bytes"),
        ("newer", "newer Keypose"),
        ("broken", "cannot be used"),
    ]:
        refused(bpy.ops.import_scene.keypose, part, directory=str(bare / name))
    require(not bpy.data.objects, "a refused import left an object behind")


def check_import(storage):
    run_project("first")
    bpy.ops.import_scene.keypose(directory=str(project), storage=storage, start=5)
    obj = bpy.context.view_layer.objects.active
    frames = shown_frames("first")
    error = worst_error(obj, frames, 5)
    require(error < TOLERANCE, f"{storage}: a vertex is {error} of the diagonal away")
    print(f"add_on_test: {storage}: worst error over diagonal {error:.2g} in {len(frames)} frames")
    # Where a picture stands, it stands between the frames too; where pictures blend, they do so in
    # a straight line.
    require(
        abs(evaluated(obj, 5, 0.9) - frames[0]).max() < 1e-6, "the first picture does not stand"
    )
    require(abs(evaluated(obj, 12, 0.9) - frames[7]).max() < 1e-6, "a step begins early")
    require(
        abs(evaluated(obj, 8, 0.5) - (frames[3] + frames[4]) / 2).max() < 1e-6,
        "pictures do not blend in a straight line",
    )
    scene = bpy.context.scene
    require(
        (scene.render.fps, round(scene.render.fps_base, 6)) == (12, 1),
        "the frame rate is not the animation's",
    )
    require(
        (scene.frame_start, scene.frame_end) == (5, 15),
        f"wrong range {scene.frame_start} to {scene.frame_end}",
    )
    marks = sorted((marker.frame, marker.name) for marker in scene.timeline_markers)
    require(marks == [(5, "rest"), (15, "bent")], f"wrong markers {marks}")
    for frame, share in [(5, 0), (9, 0.5), (12, 100 / 120), (15, 1)]:
        require(
            numpy.allclose(
                mean_color(obj, frame), numpy.array([1 - share, 0, share]) * 200 / 255, atol=1e-3
            ),
            f"the textures are not blended as they should at frame {frame}",
        )
    require(
        obj.animation_data is None or obj.animation_data.action is None,
        "the object's own action is not free",
    )
    uvs = numpy.array([loop.uv[:] for loop in obj.data.uv_layers["Keypose"].data])
    corners = numpy.array([obj.data.vertices[loop.vertex_index].co[:] for loop in obj.data.loops])
    # The limb's texture coordinates follow from its straight shape.
    require(
        numpy.allclose(
            uvs, numpy.stack([0.5 + 0.5 * corners[:, 0], corners[:, 2]], axis=1), atol=1e-6
        ),
        "wrong texture coordinates",
    )
    surface = next(
        node for node in obj.data.materials[0].node_tree.nodes if node.type == "BSDF_PRINCIPLED"
    )
    require(
        surface.inputs["Base Color"].links[0].from_node.node_tree == obj.data["keypose_textures"],
        "the material is not textured",
    )
    return obj


def work_on(obj):
    """What an artist does between two runs."""
    parent = bpy.data.objects.new("table", None)
    bpy.context.collection.objects.link(parent)
    obj.parent = parent
    obj.location = (1, 2, 3)
    obj.keyframe_insert("location", frame=7)
    obj.modifiers.new("soft", "SUBSURF").levels = 0
    own = bpy.data.materials.new("gold")
    obj.data.materials.append(own)
    top = [polygon.index for polygon in obj.data.polygons if polygon.center.z > 0.5]
    for index in top:
        obj.data.polygons[index].material_index = 1
    group = obj.vertex_groups.new(name="tip")
    group.add([vertex.index for vertex in obj.data.vertices if vertex.co.z > 0.9], 0.75, "REPLACE")
    obj.data.materials[0].node_tree.nodes["Principled BSDF"].inputs[
        "Roughness"
    ].default_value = 0.125
    bpy.context.scene.timeline_markers.new("camera cut", frame=9)
    return parent, own


def check_kept(obj, parent, own, what):
    require(obj.parent == parent, f"{what}: the parent is gone")
    require(
        obj.animation_data.action.fcurves[0].keyframe_points[0].co[0] == 7,
        f"{what}: the object's animation is gone",
    )
    require(
        [modifier.name for modifier in obj.modifiers if modifier.type == "SUBSURF"] == ["soft"],
        f"{what}: her modifier is gone",
    )
    require(obj.data.materials[1] == own, f"{what}: her material is gone")
    tops = {polygon.material_index for polygon in obj.data.polygons if polygon.center.z > 0.6}
    bottoms = {polygon.material_index for polygon in obj.data.polygons if polygon.center.z < 0.4}
    require((tops, bottoms) == ({1}, {0}), f"{what}: the materials are on other faces")
    index = obj.vertex_groups["tip"].index
    weights = [
        group.weight
        for vertex in obj.data.vertices
        for group in vertex.groups
        if group.group == index and vertex.co.z > 0.9
    ]
    require(weights and set(weights) == {0.75}, f"{what}: the vertex group is gone")
    roughness = (
        obj.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value
    )
    require(roughness == 0.125, f"{what}: the change to the material is gone")
    require("camera cut" in bpy.context.scene.timeline_markers, f"{what}: her marker is gone")


class Paper:
    """Takes the place of a panel's layout, which exists only in a window."""

    def __init__(self):
        self.texts = []

    def column(self, align=False):
        return self

    box = column

    def label(self, text, icon="NONE"):
        self.texts.append(text)

    def operator(self, name, text="", icon="NONE"):
        getattr(getattr(bpy.ops, name.split(".")[0]), name.split(".")[1]).get_rna_type()
        self.texts.append(text)

    def prop(self, data, path, text):
        data.path_resolve(path)
        self.texts.append(text)


def panel_texts():
    paper = Paper()
    context = types.SimpleNamespace(
        view_layer=bpy.context.view_layer, region=types.SimpleNamespace(width=240)
    )
    __import__("keypose_import").KeyposePanel.draw(types.SimpleNamespace(layout=paper), context)
    return paper.texts


def check_panel():
    """With a character up to date, after a further run, and with nothing selected."""
    require(
        "7 pictures, 416 faces" in panel_texts() and "Update" in panel_texts(),
        f"the panel says {panel_texts()}",
    )
    require(
        not any("again" in text for text in panel_texts()),
        "the panel asks for an update without need",
    )
    told = project / "out/animation/blender/character.json"
    os.utime(told, ns=(told.stat().st_atime_ns, told.stat().st_mtime_ns + 1_000_000_000))
    require(
        "The project ran again: press Update" in panel_texts(),
        "the panel does not see the further run",
    )
    bpy.ops.object.keypose_update()
    require(
        not any("again" in text for text in panel_texts()), "the panel still asks for an update"
    )
    obj, bpy.context.view_layer.objects.active = bpy.context.view_layer.objects.active, None
    require(
        panel_texts() == ["Import project", "Update all"], f"the empty panel says {panel_texts()}"
    )
    bpy.context.view_layer.objects.active = obj


def check_update(storage):
    obj = bpy.context.view_layer.objects.active
    parent, own = work_on(obj)
    count = (
        len(bpy.data.objects),
        len(bpy.data.materials),
        len(bpy.data.images),
        len(bpy.data.node_groups),
    )
    run_project("second")
    bpy.ops.object.keypose_update()
    error = worst_error(obj, shown_frames("second"), 5)
    require(
        error < TOLERANCE, f"{storage}: after an update a vertex is {error} of the diagonal away"
    )
    check_kept(obj, parent, own, storage)
    now = (
        len(bpy.data.objects),
        len(bpy.data.materials),
        len(bpy.data.images),
        len(bpy.data.node_groups),
    )
    require(count == now, "an update left something over")
    require(
        numpy.allclose(mean_color(obj, 5), numpy.array([100, 0, 0]) / 255, atol=1e-3),
        "the textures were not read again",
    )
    # The same by the import dialogue.
    run_project("first")
    bpy.ops.import_scene.keypose(directory=str(project / "out/animation"))
    require(
        worst_error(obj, shown_frames("first"), 5) < TOLERANCE, "the import dialogue did not update"
    )
    require(len(bpy.data.objects) == count[0], "the import dialogue made another object")
    return obj, parent, own


def check_other_faces(storage, obj, parent, own):
    old_count = len(obj.data.polygons)
    run_project("other_faces")
    bpy.ops.object.keypose_update()
    require(len(obj.data.polygons) != old_count, "the mesh was not exchanged")
    notes = __import__("keypose_import").read_state(obj)["notes"]
    require(
        any(f"instead of {old_count}" in note for note in notes),
        f"nothing is said of the other mesh: {notes}",
    )
    frames = shown_frames("other_faces")
    error = worst_error(obj, frames, 5)
    require(
        error < TOLERANCE, f"{storage}: with other faces a vertex is {error} of the diagonal away"
    )
    check_kept(obj, parent, own, storage + ", other faces")
    scene = bpy.context.scene
    # The last frame of the way back is the first of the next round.
    require(
        scene.frame_end == 5 + len(frames) - 2,
        f"wrong end {scene.frame_end} for {len(frames)} frames",
    )
    again = abs(evaluated(obj, 5 + len(frames) - 1 + 13) - frames[13]).max()
    require(again < 1e-5, "the loop does not go on")
    marks = sorted((marker.frame, marker.name) for marker in scene.timeline_markers)
    require(marks == [(5, "rest"), (9, "camera cut"), (17, "bent")], f"wrong markers {marks}")


def check_timing_and_scene(obj):
    """Her timing, frame range, rate and moved markers stay; the project's timing comes back when
    she asks for it."""
    run_project("first")
    bpy.ops.object.keypose_update()
    scene = bpy.context.scene
    curve = obj.data.animation_data.action.fcurves[0]
    curve.keyframe_points[len(curve.keyframe_points) - 1].co[0] = 22
    curve.update()
    scene.frame_end, scene.render.fps = 99, 25
    scene.timeline_markers["bent"].frame = 20
    bpy.ops.object.keypose_update()
    require(curve.keyframe_points[len(curve.keyframe_points) - 1].co[0] == 22, "her timing is gone")
    require((scene.frame_end, scene.render.fps) == (99, 25), "her frame range or rate is gone")
    require(
        20 in [marker.frame for marker in scene.timeline_markers if marker.name == "bent"],
        "her moved marker is gone",
    )
    # With her frame rate, a second is a second: frame 3 of 12 a second is at 6.25 of 25.
    bpy.ops.object.keypose_update(reset_timing=True)
    shown = evaluated(obj, 5 + 6, 0.25)
    require(
        abs(shown - shown_frames("first")[3]).max() < 1e-5,
        "the project's timing is not that of seconds",
    )
    obj.modifiers.remove(obj.modifiers["Keypose"])
    scene.render.fps, scene.frame_end = 12, 15
    bpy.ops.object.keypose_update(reset_timing=True)
    require(obj.modifiers[0].type == "MESH_CACHE", "the cache is not the first modifier")
    require(
        worst_error(obj, shown_frames("first"), 5) < TOLERANCE, "a removed cache did not come back"
    )


def check_saved_file(obj):
    """A .blend and its project move together."""
    home = folder / "home"
    home.mkdir()
    project.rename(home / "project")
    refused(bpy.ops.object.keypose_update, "no longer in")
    bpy.ops.import_scene.keypose(directory=str(home / "project"))
    bpy.ops.wm.save_as_mainfile(filepath=str(home / "film.blend"))
    bpy.ops.object.keypose_update()
    require(obj.modifiers[0].filepath.startswith("//"), "the path of the cache is not relative")
    bpy.ops.wm.save_mainfile()
    home.rename(folder / "moved")
    bpy.ops.wm.open_mainfile(filepath=str(folder / "moved/film.blend"))
    bpy.ops.preferences.addon_enable(module="keypose_import")
    obj = next(o for o in bpy.data.objects if "keypose" in o)
    require(
        worst_error(obj, shown_frames("first"), 5) < TOLERANCE, "a moved file shows another shape"
    )
    bpy.ops.object.keypose_update()


def check_y_up():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.preferences.addon_enable(module="keypose_import")
    bpy.ops.import_scene.keypose(directory=str(folder / "y_up"))
    obj = bpy.context.view_layer.objects.active
    turned = [
        numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
        for points in shown_frames("y_up")
    ]
    require(worst_error(obj, turned, 1) < TOLERANCE, "frames with y up do not stand upright")


install()
check_errors()
for way in ("CACHE", "KEYS"):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.preferences.addon_enable(module="keypose_import")
    check_import(way)
    check_panel()
    character, her_parent, her_material = check_update(way)
    check_other_faces(way, character, her_parent, her_material)
    if way == "CACHE":
        check_timing_and_scene(character)
        check_saved_file(character)
check_y_up()
print(f"add_on_test: passed {checks} checks")
