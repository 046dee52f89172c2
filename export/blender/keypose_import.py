# SPDX-License-Identifier: AGPL-3.0-or-later
"""Brings the animation of a Keypose project into Blender, and up to date after the project ran
again.

Install: Edit > Preferences > Add-ons > Install, choose this file, tick its box.
Use:     File > Import > Keypose project; later: 3D View > Sidebar (N) > Keypose > Update.

The add-on reads the folder `blender` of an exported animation (format `blender` of `keypose
export`). `character.json` has the counts and times, `character.bin` the faces (int32, three corners
each) and then the texture coordinates (float32, u and v of each corner), `character.pc2` the
positions (float32) of every picture; axes and unit are Blender's. A picture is what one or more
frames of the animation show.

One number in the mesh's data, `keypose_picture`, says which picture shows. Its F-curve is the
timing of the whole animation; shape and textures follow it through drivers, so that the object's
own action stays free.
"""

bl_info = {
    "name": "Keypose project",
    "author": "The Keypose authors",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > Keypose project; 3D View > Sidebar > Keypose",
    "description": "Imports an animated clay character with textures, keys and timing; updates it",
    "support": "COMMUNITY",
    "category": "Import-Export",
}

import json
import os

import bpy
import numpy
from mathutils import kdtree

SCHEMA = 1
STATE = "keypose"  # custom property of the object: what was brought in, as JSON
PICTURE = "keypose_picture"  # custom property of the mesh: the picture that shows
PICTURE_PATH = f'["{PICTURE}"]'
TEXTURES = (
    "keypose_textures"  # custom property of the mesh: the node group that blends the textures
)
UV_LAYER = "Keypose"
PC2_HEADER_BYTES = 32


class Unusable(Exception):
    """What is wrong and what to do, in a sentence for the artist."""


# ---- Files ---------------------------------------------------------------------------------------


def find_files(chosen):
    """The folder with character.json that belongs to a chosen project, animation or file."""
    chosen = os.path.abspath(bpy.path.abspath(chosen))
    if os.path.isfile(chosen):
        chosen = os.path.dirname(chosen)
    for below in ("out/animation/blender", "animation/blender", "blender", "."):
        folder = os.path.normpath(os.path.join(chosen, below))
        if os.path.isfile(os.path.join(folder, "character.json")):
            return folder
    raise Unusable(why_no_files(chosen))


def why_no_files(chosen):
    if not os.path.isdir(chosen):
        return f"There is no folder {chosen}. Choose the folder of a Keypose project"
    for below in ("out/animation", "animation", "."):
        if os.path.isfile(os.path.join(chosen, below, "animation.json")):
            return (
                f"The animation in {os.path.normpath(os.path.join(chosen, below))} was exported "
                "without the files for "
                "Blender. Add blender to the formats of `export` in the project's pipeline.yaml "
                "(or `keypose run --set "
                "export.formats=glb,video,blender`), run `keypose run`, and import again"
            )
    if os.path.isfile(os.path.join(chosen, "pipeline.yaml")):
        return (
            f"The project {chosen} has no animation yet. Run `keypose run` there, with two poses "
            "or more, "
            "and import again"
        )
    return (
        f"{chosen} is not a Keypose project: it has neither a pipeline.yaml nor an animation. "
        "Choose the folder "
        "in which `keypose run` works"
    )


class Character:
    """The animation as Keypose wrote it."""

    def __init__(self, folder):
        self.folder = folder
        self.json_path = os.path.join(folder, "character.json")
        self.cache_path = os.path.join(folder, "character.pc2")
        try:
            with open(self.json_path, encoding="utf-8") as file:
                told = json.load(file)
            if told["schema"] > SCHEMA:
                raise Unusable(
                    f"{folder} was written by a newer Keypose. Install the add-on that lies beside "
                    "it: "
                    f"{os.path.join(folder, 'keypose_import.py')}"
                )
            self.name, self.fps, self.loops = told["name"], told["fps"], told["loops"]
            self.vertex_count, self.face_count = told["vertices"], told["faces"]
            self.picture_count, self.shown_count = told["pictures"], told["shown_frames"]
            self.moments, self.keys = told["moments"], told["keys"]
            self.textures, self.weights = told["textures"], told["weights"]
            has_uvs = told["has_uvs"]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise Unusable(
                f"{self.json_path} cannot be used ({error!r}). Run `keypose run` again"
            ) from error
        corners = 3 * self.face_count
        sizes = {
            "character.bin": 4 * corners + (8 * corners if has_uvs else 0),
            "character.pc2": PC2_HEADER_BYTES + 12 * self.vertex_count * self.picture_count,
        }
        for name, size in sizes.items():
            path = os.path.join(folder, name)
            found = os.path.getsize(path) if os.path.isfile(path) else 0
            if found != size:
                raise Unusable(
                    f"{path} has {found} bytes, but {size} belong there: it was not copied or "
                    "written whole. "
                    "Copy it again, or run `keypose run` again"
                )
        data = numpy.fromfile(os.path.join(folder, "character.bin"), "<u1")
        self.faces = data[: 4 * corners].view("<i4").reshape(-1, 3)
        self.uvs = data[4 * corners :].view("<f4") if has_uvs else None
        self.written = os.stat(self.json_path).st_mtime

    def points(self, picture):
        """V x 3, float32."""
        flat = numpy.fromfile(
            self.cache_path,
            "<f4",
            3 * self.vertex_count,
            offset=PC2_HEADER_BYTES + 12 * self.vertex_count * picture,
        )
        return flat.reshape(-1, 3)


def stored_path(path):
    """Relative to the .blend file where it has one."""
    if not bpy.data.filepath:
        return path
    try:
        return bpy.path.relpath(path)
    except ValueError:  # on another drive
        return path


def read_state(obj):
    return json.loads(obj[STATE]) if STATE in obj else {}


def is_character(obj):
    return obj is not None and obj.type == "MESH" and STATE in obj


# ---- Mesh ----------------------------------------------------------------------------------------


def same_faces(mesh, faces, vertex_count):
    if (len(mesh.vertices), len(mesh.polygons), len(mesh.loops)) != (
        vertex_count,
        len(faces),
        faces.size,
    ):
        return False
    corners = numpy.empty(faces.size, numpy.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    return numpy.array_equal(corners, faces.reshape(-1))


def rest_positions(mesh):
    flat = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def nearest(of, to):
    """For each row of `to` the nearest row of `of`."""
    tree = kdtree.KDTree(len(of))
    for i, place in enumerate(of):
        tree.insert(place, i)
    tree.balance()
    return [tree.find(place)[1] for place in to]


class Painted:
    """What an artist put on the faces and vertices of a mesh; laid by nearest places on its
    successor."""

    def __init__(self, obj):
        mesh = obj.data
        self.points = rest_positions(mesh)
        self.centers = numpy.array([polygon.center for polygon in mesh.polygons]).reshape(-1, 3)
        self.materials = [polygon.material_index for polygon in mesh.polygons]
        self.smooth = [polygon.use_smooth for polygon in mesh.polygons]
        names = [group.name for group in obj.vertex_groups]
        self.group_names = names
        self.groups = [
            [(names[group.group], group.weight) for group in vertex.groups]
            for vertex in mesh.vertices
        ]
        self.lost = (
            [f"{len(mesh.uv_layers) - 1} UV layers of yours"] if len(mesh.uv_layers) > 1 else []
        )
        self.lost += (
            [f"{len(mesh.color_attributes)} colour layers"] if mesh.color_attributes else []
        )
        self.lost += ["your shape keys"] if mesh.shape_keys and mesh.shape_keys.use_relative else []

    def lay_on(self, obj):
        mesh = obj.data
        if not len(self.points) or not self.materials:
            return
        if len(set(zip(self.materials, self.smooth))) == 1:
            faces = [0] * len(mesh.polygons)
        else:
            faces = nearest(self.centers, [polygon.center for polygon in mesh.polygons])
        mesh.polygons.foreach_set("material_index", [self.materials[face] for face in faces])
        mesh.polygons.foreach_set("use_smooth", [self.smooth[face] for face in faces])
        groups = {
            name: obj.vertex_groups.get(name) or obj.vertex_groups.new(name=name)
            for name in self.group_names
        }
        same_weight = {}
        for vertex, old in enumerate(nearest(self.points, rest_positions(mesh)) if groups else []):
            for pair in self.groups[old]:
                same_weight.setdefault(pair, []).append(vertex)
        for (name, weight), vertices in same_weight.items():
            groups[name].add(vertices, weight, "REPLACE")


def build_mesh(mesh, character):
    mesh.clear_geometry()
    mesh.from_pydata(character.points(0).tolist(), [], character.faces.tolist())
    mesh.update()
    if not same_faces(mesh, character.faces, character.vertex_count):
        raise Unusable(
            "Blender changed the order of the faces; report this with the project and your "
            "Blender's version"
        )


def shape_mesh(obj, character, notes):
    """Gives the object's mesh the faces, rest positions and texture coordinates of the
    character."""
    mesh = obj.data
    if not same_faces(mesh, character.faces, character.vertex_count):
        old_count, painted = len(mesh.polygons), Painted(obj)
        if mesh.shape_keys:
            obj.shape_key_clear()
        build_mesh(mesh, character)
        painted.lay_on(obj)
        if old_count:
            notes.append(
                f"The mesh is another one: {character.face_count} faces instead of {old_count}. "
                "Materials, modifiers "
                "and vertex groups were kept, by nearest places"
                + (f"; {', '.join(painted.lost)} were lost" if painted.lost else "")
            )
        else:
            mesh.polygons.foreach_set("use_smooth", [True] * character.face_count)
    else:
        mesh.vertices.foreach_set("co", character.points(0).reshape(-1))
        if mesh.shape_keys:
            mesh.shape_keys.reference_key.data.foreach_set("co", character.points(0).reshape(-1))
    if character.uvs is not None:
        layer = mesh.uv_layers.get(UV_LAYER) or mesh.uv_layers.new(name=UV_LAYER)
        layer.data.foreach_set("uv", character.uvs)
    mesh.update()


# ---- Curves and drivers --------------------------------------------------------------------------


def fill_curve(curve, keys):
    """@param keys  rows of time, value, interpolation"""
    points = curve.keyframe_points
    while len(points):
        points.remove(points[len(points) - 1], fast=True)
    points.add(len(keys))
    for point, (time, value, interpolation) in zip(points, keys):
        point.co = (time, value)
        point.interpolation = interpolation
        point.handle_left_type = point.handle_right_type = "AUTO_CLAMPED"
    curve.update()


def find_curve(block, path):
    """The F-curve of a property in the block's action, or None. Blender 4.4 and later sort curves
    by slots."""
    data = block.animation_data
    if data is None or data.action is None:
        return None
    curves = getattr(data.action, "fcurves", None)
    if curves is None:
        bags = [
            bag
            for layer in data.action.layers
            for strip in layer.strips
            for bag in strip.channelbags
        ]
        curves = [
            curve
            for bag in bags
            if bag.slot_handle == data.action_slot_handle
            for curve in bag.fcurves
        ]
    return next((curve for curve in curves if curve.data_path == path), None)


def drive(block, path, mesh, pairs=()):
    """Lets a property follow the picture that shows, through pairs (picture, value) with straight
    lines in between;
    without pairs it is the picture. No Python runs in it, so that it needs no trust."""
    block.driver_remove(path)
    curve = block.driver_add(path)
    curve.driver.type = "SUM"
    variable = curve.driver.variables.new()
    variable.name = "picture"
    variable.targets[0].id_type = "MESH"
    variable.targets[0].id = mesh
    variable.targets[0].data_path = PICTURE_PATH
    if pairs:
        for modifier in list(curve.modifiers):
            curve.modifiers.remove(modifier)
        fill_curve(curve, [(picture, value, "LINEAR") for picture, value in without_middles(pairs)])


def without_middles(pairs):
    """Points without those that lie on the line between their neighbours."""
    kept = [pairs[0]]
    for (x, y), (next_x, next_y) in zip(pairs[1:], pairs[2:]):
        last_x, last_y = kept[-1]
        if abs((y - last_y) * (next_x - x) - (next_y - y) * (x - last_x)) > 1e-9:
            kept.append((x, y))
    return kept + list(pairs[-1:] if len(pairs) > 1 else [])


# ---- Timing --------------------------------------------------------------------------------------


def timing_keys(character, start, scene_fps):
    """The curve of the picture that shows: straight where pictures blend, level where one stands.
    Keyframes are at the
    keys, and where the pace changes."""
    rows = [
        (
            start + moment["seconds"] * scene_fps,
            moment["picture"],
            "CONSTANT" if moment["stands"] else "LINEAR",
        )
        for moment in character.moments
    ]
    at_keys = [start + key["seconds"] * scene_fps for key in character.keys]
    kept = []
    for i, (time, value, kind) in enumerate(rows):
        inside = 0 < i < len(rows) - 1 and not any(abs(time - at) < 1e-6 for at in at_keys)
        if inside and kind == kept[-1][2] == "LINEAR":
            (last_time, last_value, _), (next_time, next_value, _) = kept[-1], rows[i + 1]
            bend = (value - last_value) * (next_time - time) - (next_value - value) * (
                time - last_time
            )
            inside = abs(bend) < 1e-6
        elif inside:
            inside = kind == kept[-1][2] and value == kept[-1][1]
        if not inside:
            kept.append((time, float(value), kind))
    return kept


def curve_rows(curve):
    return [
        [round(point.co[0], 3), round(point.co[1], 3), point.interpolation]
        for point in curve.keyframe_points
    ]


def set_timing(mesh, character, keys, state, reset, notes):
    """Writes the timing, unless the artist changed it since it was written."""
    curve = find_curve(mesh, PICTURE_PATH)
    changed = curve is not None and "timing" in state and curve_rows(curve) != state["timing"]
    if changed and not reset:
        if state["pictures"] == character.picture_count:
            notes.append(
                "Your timing was kept. Update with 'Timing of the project' takes the project's"
            )
            return
        action = mesh.animation_data.action
        mesh.animation_data.action = action.copy()
        action.name, action.use_fake_user = f"{character.name}: timing before the update", True
        notes.append(
            f"The animation has {character.picture_count} pictures instead of {state['pictures']}, "
            "so the project's timing "
            f"was taken. Yours is kept as the action '{action.name}'"
        )
    if PICTURE not in mesh:
        mesh[PICTURE] = 0.0
    mesh.id_properties_ui(PICTURE).update(
        min=0.0,
        max=max(1.0, character.picture_count - 1.0),
        description="The picture of the animation that shows",
    )
    mesh.keyframe_insert(PICTURE_PATH, frame=keys[0][0])
    curve = find_curve(mesh, PICTURE_PATH)
    if curve.id_data.users == 1 and "timing" not in state:
        curve.id_data.name = f"{character.name}: timing"
    fill_curve(curve, keys)
    for modifier in [modifier for modifier in curve.modifiers if modifier.type == "CYCLES"]:
        curve.modifiers.remove(modifier)
    if character.loops and len(keys) > 1:
        curve.modifiers.new("CYCLES")
    state["timing"] = curve_rows(curve)


# ---- Where the pictures are kept -----------------------------------------------------------------


def set_cache(obj, character, state, notes):
    """A Mesh Cache modifier that reads the positions from the project."""
    modifier = obj.modifiers.get(state.get("modifier", ""))
    if modifier is None or modifier.type != "MESH_CACHE":
        if "modifier" in state:
            notes.append(
                f"The modifier '{state['modifier']}' that plays the animation was gone; it is "
                "back, before all others"
            )
        modifier = obj.modifiers.new("Keypose", "MESH_CACHE")
        context = {"object": obj, "active_object": obj}
        with bpy.context.temp_override(**context):
            bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)
        modifier = obj.modifiers[0]
    modifier.cache_format = "PC2"
    modifier.filepath = stored_path(character.cache_path)
    modifier.interpolation = "LINEAR"
    modifier.time_mode, modifier.play_mode = "FRAME", "CUSTOM"
    drive(obj, f'modifiers["{bpy.utils.escape_identifier(modifier.name)}"].eval_frame', obj.data)
    state["modifier"] = modifier.name


def set_shape_keys(obj, character):
    """A shape key for each picture, one after the other in time."""
    mesh = obj.data
    present = len(mesh.shape_keys.key_blocks) if mesh.shape_keys else 0
    if present != character.picture_count:
        if present:
            obj.shape_key_clear()
        for picture in range(character.picture_count):
            obj.shape_key_add(
                name=f"picture {picture}", from_mix=False
            ).interpolation = "KEY_LINEAR"
        mesh.shape_keys.use_relative = False
    for picture, block in enumerate(mesh.shape_keys.key_blocks):
        block.data.foreach_set("co", character.points(picture).reshape(-1))
    drive(
        mesh.shape_keys,
        "eval_time",
        mesh,
        [(i, block.frame) for i, block in enumerate(mesh.shape_keys.key_blocks)],
    )


# ---- Textures ------------------------------------------------------------------------------------


def load_image(character, texture, notes):
    path = os.path.normpath(os.path.join(character.folder, texture["file"]))
    try:
        image = bpy.data.images.load(path, check_existing=True)
    except RuntimeError:
        notes.append(f"The texture {path} cannot be read; run `keypose run` again, then Update")
        return None
    was_packed = image.packed_file is not None
    if was_packed:
        image.unpack(method="REMOVE")
    if image.filepath != stored_path(path):
        image.filepath = stored_path(path)
    image.reload()
    if was_packed:
        image.pack()
    return image


def rebuild_group(group, textures):
    """One Image Texture node a pose, each added with its weight. The weights sum to 1."""
    for curve in list(group.animation_data.drivers if group.animation_data else []):
        group.animation_data.drivers.remove(curve)
    group.nodes.clear()
    if hasattr(group, "interface"):  # Blender 4
        if not len(group.interface.items_tree):
            group.interface.new_socket(name="Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    elif not len(group.outputs):
        group.outputs.new("NodeSocketColor", "Color")
    uv_map = group.nodes.new("ShaderNodeUVMap")
    uv_map.uv_map, uv_map.location = UV_LAYER, (-600, 0)
    color = None
    for i, texture in enumerate(textures):
        node = group.nodes.new("ShaderNodeTexImage")
        node.name, node.label = f"texture {i}", texture["pose"]
        node.location, node.width = (-350, -300 * i), 240
        group.links.new(uv_map.outputs[0], node.inputs[0])
        if len(textures) == 1:
            color = node.outputs["Color"]
            break
        mix = group.nodes.new("ShaderNodeMix")
        mix.name, mix.label = f"weight {i}", f"{texture['pose']}: weight"
        mix.data_type, mix.blend_type = "RGBA", "ADD"
        mix.location = (-50 + 200 * i, -150 * i)
        mix.inputs[6].default_value = (0, 0, 0, 1)
        if color is not None:
            group.links.new(color, mix.inputs[6])
        group.links.new(node.outputs["Color"], mix.inputs[7])
        color = mix.outputs[2]
    output = group.nodes.new("NodeGroupOutput")
    output.location = (200 + 200 * len(textures), 0)
    group.links.new(color, output.inputs[0])


def set_textures(mesh, character, notes):
    """A node group that shows the textures by their weights. @return it, or None; and whether it is
    new"""
    group = mesh.get(TEXTURES)
    if character.uvs is None or not character.textures:
        return group, False
    is_new = group is None
    if is_new:
        group = bpy.data.node_groups.new(f"{character.name}: textures", "ShaderNodeTree")
        mesh[TEXTURES] = group
    labels = [node.label for node in group.nodes if node.type == "TEX_IMAGE"]
    if labels != [texture["pose"] for texture in character.textures]:
        rebuild_group(group, character.textures)
    for i, texture in enumerate(character.textures):
        node = group.nodes.get(f"texture {i}")
        if node is not None:
            node.image = load_image(character, texture, notes) or node.image
        weights = [row[i] for row in character.weights] or [float(i == 0)] * character.picture_count
        if f"weight {i}" in group.nodes:
            drive(
                group,
                f'nodes["weight {i}"].inputs[0].default_value',
                mesh,
                list(enumerate(weights)),
            )
    return group, is_new


def add_material(mesh, character, group):
    material = bpy.data.materials.new(f"{character.name}: clay")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    surface.inputs["Roughness"].default_value = 0.8
    if group is not None:
        node = nodes.new("ShaderNodeGroup")
        node.node_tree, node.name = group, "Keypose textures"
        node.location = (surface.location[0] - 250, surface.location[1])
        material.node_tree.links.new(node.outputs[0], surface.inputs["Base Color"])
        nodes.active = node
    mesh.materials.append(material)


# ---- Scene ---------------------------------------------------------------------------------------


def fps_of(scene):
    return scene.render.fps / scene.render.fps_base


def set_scene(scene, character, state, notes):
    """Frame rate and range, unless the artist changed them since."""
    if "fps" in state and abs(fps_of(scene) - state["fps"]) > 1e-3:
        if abs(fps_of(scene) - character.fps) > 1e-3:
            notes.append(
                f"Your frame rate of {fps_of(scene):g} was kept; the animation was made at "
                f"{character.fps:g}"
            )
    else:
        scene.render.fps = max(1, round(character.fps))
        scene.render.fps_base = scene.render.fps / character.fps
        state["fps"] = character.fps
    if "range" in state and [scene.frame_start, scene.frame_end] != state["range"]:
        notes.append(f"Your frame range of {scene.frame_start} to {scene.frame_end} was kept")
        return
    # The last frame of a loop is the first of the next round.
    count = character.shown_count - (1 if character.loops and character.shown_count > 1 else 0)
    frames = max(1, round(count / character.fps * fps_of(scene)))
    scene.frame_start, scene.frame_end = state["start"], state["start"] + frames - 1
    state["range"] = [scene.frame_start, scene.frame_end]


def set_markers(scene, character, state):
    """A marker for each key. Markers that the artist moved, renamed or made are hers."""
    ours = [(name, frame) for name, frame in state.get("markers", [])]
    for marker in list(scene.timeline_markers):
        if (marker.name, marker.frame) in ours:
            scene.timeline_markers.remove(marker)
    present = {(marker.name, marker.frame) for marker in scene.timeline_markers}
    state["markers"] = []
    for key in character.keys:
        mark = (key["pose"], state["start"] + round(key["seconds"] * fps_of(scene)))
        if mark not in present:
            scene.timeline_markers.new(mark[0], frame=mark[1])
            present.add(mark)
            state["markers"].append(mark)


# ---- Import and update ---------------------------------------------------------------------------


def bring_up_to_date(scene, obj, character, state, reset_timing=False):
    """Makes an object show the character. What the artist made of it stays. @return sentences on
    what she should know"""
    notes = []
    mesh = obj.data
    if obj.library or mesh.library:
        raise Unusable(f"{obj.name} is linked from another file; update it in that file")
    if obj.mode != "OBJECT":
        raise Unusable(f"{obj.name} is being edited; go back to Object Mode first")
    is_new = len(mesh.vertices) == 0
    if state["own_scene"]:
        set_scene(scene, character, state, notes)
    shape_mesh(obj, character, notes)
    keys = timing_keys(character, state["start"], fps_of(scene))
    set_timing(mesh, character, keys, state, reset_timing, notes)
    if state["storage"] == "CACHE":
        set_cache(obj, character, state, notes)
    else:
        set_shape_keys(obj, character)
    group, new_group = set_textures(mesh, character, notes)
    if is_new:
        add_material(mesh, character, group)
    elif new_group:
        notes.append(
            f"The textures are in the new node group '{group.name}': add it to your material"
        )
    set_markers(scene, character, state)
    state.update(
        folder=stored_path(character.folder),
        pictures=character.picture_count,
        written=character.written,
        notes=notes,
    )
    obj[STATE] = json.dumps(state)
    mesh.update_tag()
    obj.update_tag()
    return notes


def folder_of(obj):
    """Where the files of an object are: the folder that it came from, or that of its cache if files
    were moved together."""
    state = read_state(obj)
    places = [bpy.path.abspath(state["folder"])]
    modifier = obj.modifiers.get(state.get("modifier", ""))
    if modifier is not None and modifier.type == "MESH_CACHE":
        places.append(os.path.dirname(bpy.path.abspath(modifier.filepath)))
    for place in places:
        if os.path.isfile(os.path.join(place, "character.json")):
            return os.path.normpath(place)
    raise Unusable(
        f"The files of {obj.name} are no longer in {places[0]}. Select it, then File > Import > "
        "Keypose project, "
        "and choose where the project is"
    )


def object_to_update(context, folder):
    """The object that shows this folder; or the selected character whose own folder is gone."""
    candidates = [context.view_layer.objects.active] + list(context.scene.objects)
    for obj in filter(is_character, candidates):
        if os.path.normpath(bpy.path.abspath(read_state(obj)["folder"])) == folder:
            return obj
    active = context.view_layer.objects.active
    if is_character(active) and not os.path.isdir(bpy.path.abspath(read_state(active)["folder"])):
        return active
    return None


class ImportKeypose(bpy.types.Operator):
    """Import the character of a Keypose project: its shape at every frame, textures, keys and
    timing"""

    bl_idname = "import_scene.keypose"
    bl_label = "Import Keypose project"
    bl_options = {"REGISTER", "UNDO"}

    directory: bpy.props.StringProperty(
        name="Project", description="The project's folder, or its out/animation", subtype="DIR_PATH"
    )
    filter_folder: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    update_existing: bpy.props.BoolProperty(
        name="Update if it is there",
        default=True,
        description="If the scene has this project's character, bring it up to date, with your "
        "materials and modifiers kept; "
        "off: import another one",
    )
    storage: bpy.props.EnumProperty(
        name="Keep pictures in",
        default="CACHE",
        items=[
            (
                "CACHE",
                "Point cache",
                "Light: a Mesh Cache modifier reads each picture from the project when it is shown",
            ),
            (
                "KEYS",
                "Shape keys",
                "Every picture can be sculpted, and is kept in the .blend file. Updates overwrite "
                "what was "
                "sculpted",
            ),
        ],
    )
    start: bpy.props.IntProperty(
        name="First frame",
        default=1,
        description="The frame of the scene at which the animation begins",
    )
    set_scene: bpy.props.BoolProperty(
        name="Set frame rate and range",
        default=True,
        description="The scene takes the frame rate and length of the animation",
    )

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            folder = find_files(self.directory)
            character = Character(folder)
            obj = object_to_update(context, folder) if self.update_existing else None
            if obj is not None:
                notes = bring_up_to_date(context.scene, obj, character, read_state(obj))
            else:
                obj, notes = self.add(context, character)
        except Unusable as error:
            self.report({"ERROR"}, f"{error}.")
            return {"CANCELLED"}
        tell(self, obj, character, notes)
        return {"FINISHED"}

    def add(self, context, character):
        if context.mode != "OBJECT":
            raise Unusable("An object is being edited; go back to Object Mode first")
        mesh = bpy.data.meshes.new(character.name)
        obj = bpy.data.objects.new(character.name, mesh)
        context.collection.objects.link(obj)
        state = {"storage": self.storage, "start": self.start, "own_scene": self.set_scene}
        notes = bring_up_to_date(context.scene, obj, character, state)
        for other in context.selected_objects:
            other.select_set(False)
        obj.select_set(True)
        context.view_layer.objects.active = obj
        return obj, notes


class UpdateKeypose(bpy.types.Operator):
    """Bring the selected Keypose characters, or all if none is selected, up to date with their
    projects. Your materials,
    modifiers, parents, animation and markers stay"""

    bl_idname = "object.keypose_update"
    bl_label = "Update from Keypose"
    bl_options = {"REGISTER", "UNDO"}

    reset_timing: bpy.props.BoolProperty(
        name="Timing of the project",
        default=False,
        description="Take the project's timing even if you changed the timing here",
    )

    @classmethod
    def poll(cls, context):
        return any(is_character(obj) for obj in context.scene.objects)

    def execute(self, context):
        selected = [obj for obj in context.selected_objects if is_character(obj)]
        for obj in selected or [obj for obj in context.scene.objects if is_character(obj)]:
            try:
                character = Character(folder_of(obj))
                notes = bring_up_to_date(
                    context.scene, obj, character, read_state(obj), self.reset_timing
                )
            except Unusable as error:
                self.report({"ERROR"}, f"{error}.")
                return {"CANCELLED"}
            tell(self, obj, character, notes)
        return {"FINISHED"}


def tell(operator, obj, character, notes):
    for note in notes:
        operator.report({"WARNING"}, f"{note}.")
    operator.report(
        {"INFO"},
        f"{obj.name}: {character.shown_count} frames at {character.fps:g} frames per second, "
        f"{character.face_count} faces",
    )


class KeyposePanel(bpy.types.Panel):
    bl_label = "Keypose"
    bl_idname = "VIEW3D_PT_keypose"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Keypose"

    def draw(self, context):
        layout, obj = self.layout, context.view_layer.objects.active
        if not is_character(obj):
            layout.operator(ImportKeypose.bl_idname, text="Import project", icon="IMPORT")
            layout.operator(UpdateKeypose.bl_idname, text="Update all", icon="FILE_REFRESH")
            return
        state = read_state(obj)
        path = os.path.join(bpy.path.abspath(state["folder"]), "character.json")
        column = layout.column(align=True)
        column.label(text=obj.name, icon="MESH_DATA")
        column.label(text=f"{state['pictures']} pictures, {len(obj.data.polygons)} faces")
        if not os.path.isfile(path):
            column.label(text="The project is gone: import it again", icon="ERROR")
        elif os.stat(path).st_mtime != state["written"]:
            column.label(text="The project ran again: press Update", icon="INFO")
        layout.operator(UpdateKeypose.bl_idname, text="Update", icon="FILE_REFRESH")
        layout.prop(obj.data, PICTURE_PATH, text="Picture")
        for note in state["notes"]:
            box = layout.box().column(align=True)
            for line in wrapped(note, max(20, context.region.width // 8)):
                box.label(text=line)


def wrapped(text, width):
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) >= width and lines[-1]:
            lines.append("")
        lines[-1] += word + " "
    return lines


CLASSES = (ImportKeypose, UpdateKeypose, KeyposePanel)


def draw_import(self, context):
    self.layout.operator(ImportKeypose.bl_idname, text="Keypose project (folder)")


def draw_object(self, context):
    self.layout.operator(UpdateKeypose.bl_idname)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(draw_import)
    bpy.types.VIEW3D_MT_object.append(draw_object)


def unregister():
    bpy.types.VIEW3D_MT_object.remove(draw_object)
    bpy.types.TOPBAR_MT_file_import.remove(draw_import)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


if __name__ == "__main__":
    register()
