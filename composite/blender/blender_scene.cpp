#include "composite/blender/blender_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr double kTableSide = 10;  // half of it, over the character's diagonal

/// Builds the scene in Blender; reads the files beside it.
constexpr const char* kScript =
    R"PY("""Builds this shot in Blender: its camera, the film behind it, the character, and its light.

Open it in Blender's text editor and run it, or: blender --python shot.py
"""
import array
import json
import pathlib

import bpy
import mathutils

HERE = pathlib.Path(__file__).resolve().parent if "__file__" in globals() else pathlib.Path(
    bpy.context.space_data.text.filepath).resolve().parent
SHOT = json.loads((HERE / "shot.json").read_text(encoding="utf-8"))


def move_camera(camera, path):
    """One key for each picture: a camera that moves on no straight line."""
    camera.rotation_mode = "QUATERNION"
    for picture, matrix in enumerate(path):
        rows = [matrix[4 * i : 4 * i + 4] for i in range(4)]
        place, turn, _ = mathutils.Matrix(rows).decompose()
        before = camera.rotation_quaternion.copy()
        turn.make_compatible(before)
        camera.location, camera.rotation_quaternion = place, turn
        camera.keyframe_insert("location", frame=picture)
        camera.keyframe_insert("rotation_quaternion", frame=picture)


def make_camera(scene):
    spec = SHOT["camera"]
    data = bpy.data.cameras.new("shot")
    data.sensor_fit = "HORIZONTAL"
    data.sensor_width = spec["sensor_width_mm"]
    data.lens = spec["lens_mm"]
    data.shift_x, data.shift_y = spec["shift_x"], spec["shift_y"]
    data.clip_start, data.clip_end = spec["clip_start"], spec["clip_end"]
    camera = bpy.data.objects.new("shot", data)
    rows = [spec["matrix_world"][4 * i : 4 * i + 4] for i in range(4)]
    camera.matrix_world = mathutils.Matrix(rows)
    move_camera(camera, spec["path"])
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.resolution_x, render.resolution_y = spec["width"], spec["height"]
    render.resolution_percentage = 100
    aspect = spec["pixel_aspect_y"]
    render.pixel_aspect_x, render.pixel_aspect_y = max(1, 1 / aspect), max(1, aspect)
    render.film_transparent = True
    data.show_background_images = True
    return data


def show_film(data):
    if not SHOT["film"]:
        return
    background = data.background_images.new()
    background.image = bpy.data.images.load(str(HERE / SHOT["film"]))
    background.image.source = "SEQUENCE"
    background.image_user.frame_duration = SHOT["pictures"]
    background.image_user.frame_start = 0
    background.image_user.frame_offset = -1
    background.alpha = 1
    if SHOT["plate"]:
        bpy.data.images.load(str(HERE / SHOT["plate"])).use_fake_user = True


class Gains:
    """Nodes for the light of the set on the character: a quadratic of the normal, per channel."""

    def __init__(self, tree):
        self.tree = tree
        self.normal = tree.nodes.new("ShaderNodeNewGeometry").outputs["Normal"]

    def node(self, kind, operation, first, second, output):
        node = self.tree.nodes.new(kind)
        node.operation = operation
        for socket, value in zip(node.inputs, (first, second)):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node.outputs[output]

    def number(self, operation, first, second):
        return self.node("ShaderNodeMath", operation, first, second, "Value")

    def dot(self, first, second):
        return self.node("ShaderNodeVectorMath", "DOT_PRODUCT", first, second, "Value")

    def joined(self, numbers):
        node = self.tree.nodes.new("ShaderNodeCombineXYZ")
        for socket, number in zip(node.inputs, numbers):
            self.tree.links.new(number, socket)
        return node.outputs["Vector"]

    def channel(self, h):
        """Of 1, x, y, z, xy, yz, xz, xx - yy, 3 zz - 1."""
        rows = (
            ((h[7], h[4] / 2, h[6] / 2), h[1]),
            ((h[4] / 2, -h[7], h[5] / 2), h[2]),
            ((h[6] / 2, h[5] / 2, 3 * h[8]), h[3]),
        )
        sums = [self.number("ADD", self.dot(self.normal, row), line) for row, line in rows]
        light = self.number("ADD", self.dot(self.normal, self.joined(sums)), h[0] - h[8])
        return self.number("MINIMUM", self.number("MAXIMUM", light, 0.05), 8)

    def times(self, colour):
        gains = self.joined([self.channel(h) for h in SHOT["light"]["on_character"]])
        return self.node("ShaderNodeVectorMath", "MULTIPLY", colour, gains, "Vector")


def make_material():
    material = bpy.data.materials.new("character")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = 0.7
    if SHOT["textures"]:
        texture = nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.load(str(HERE / SHOT["textures"][0]))
        links.new(texture.outputs["Color"], shader.inputs["Base Color"])
        # The texture holds the light of the photographs; the set's light over it was learnt from
        # the film, by the normal. Both glow for the camera alone, so that nothing falls on the
        # table. To light the character by the scene's lamps, join the Principled BSDF to the
        # Material Output.
        glow = nodes.new("ShaderNodeEmission")
        colour = texture.outputs["Color"]
        if SHOT["light"]:
            colour = Gains(material.node_tree).times(colour)
            seen = nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"]
            links.new(seen, glow.inputs["Strength"])
        links.new(colour, glow.inputs["Color"])
        links.new(glow.outputs["Emission"], nodes["Material Output"].inputs["Surface"])
    return material


def make_sun(scene, name, energy, towards, angle):
    data = bpy.data.lights.new(name, "SUN")
    data.energy, data.angle = energy, angle
    sun = bpy.data.objects.new(name, data)
    sun.rotation_mode = "QUATERNION"
    sun.rotation_quaternion = mathutils.Vector(towards).to_track_quat("Z", "Y")
    table = SHOT["light"]["table"]
    sun.location = mathutils.Vector(table["middle"]) + table["diagonal"] * mathutils.Vector(towards)
    scene.collection.objects.link(sun)
    return data


def make_table(scene):
    """Catches the shadow, and is not seen itself."""
    mesh = bpy.data.meshes.new("table")
    mesh.from_pydata(SHOT["light"]["table"]["corners"], [], [(0, 1, 2, 3)])
    table = bpy.data.objects.new("table", mesh)
    scene.collection.objects.link(table)
    if hasattr(table, "is_shadow_catcher"):
        table.is_shadow_catcher = True
    else:
        table.cycles.is_shadow_catcher = True


def make_light(scene):
    """Sky and lamp as the film's shadow tells; together they make a white table white."""
    light = SHOT["light"]
    if not light:
        return
    sky = bpy.data.worlds.new("sky")
    sky.use_nodes = True
    background = sky.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = light["sky"]
    scene.world = sky
    if light["lamp"]:
        make_sun(scene, "lamp", light["lamp"], light["towards_lamp"], light["lamp_angle"])
    if light["even"]:  # what the set gives back into its shadows
        even = make_sun(scene, "even light", light["even"], light["table"]["up"], 0)
        if hasattr(even, "cycles") and hasattr(even.cycles, "cast_shadow"):
            even.cycles.cast_shadow = False
        even.use_shadow = False
    if light["shadow"]:
        make_table(scene)
    # Only Cycles catches shadows.
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 128
    scene.cycles.use_denoising = False  # some builds have none, and would not render


def lay_over_plate(scene):
    """F12 shows the character over the set. Of a moving camera the set is left to you."""
    if not SHOT["plate"]:
        return
    scene.use_nodes = True
    tree = getattr(scene, "node_tree", None)
    if tree is None:
        print("lay the render over", SHOT["plate"], "in the compositor of this Blender")
        return
    tree.nodes.clear()
    render, plate, over, result = (
        tree.nodes.new("CompositorNode" + kind)
        for kind in ("RLayers", "Image", "AlphaOver", "Composite")
    )
    plate.image = bpy.data.images.load(str(HERE / SHOT["plate"]), check_existing=True)
    tree.links.new(plate.outputs["Image"], over.inputs[1])
    tree.links.new(render.outputs["Image"], over.inputs[2])
    tree.links.new(over.outputs["Image"], result.inputs["Image"])


def show_colours_as_filmed(scene):
    """Blender's own view of bright colours (AgX, Filmic) is not for pictures that are finished."""
    try:
        scene.view_settings.view_transform = "Standard"
    except TypeError:
        print("this Blender has no view transform Standard: colours differ from the film's")


def make_character(scene):
    count, faces = SHOT["vertices"], SHOT["faces"]
    bytes_ = (HERE / "character.bin").read_bytes()
    corners = array.array("i", bytes_[: 12 * faces])
    uvs = array.array("f", bytes_[12 * faces :])
    first = array.array("f", (HERE / "character.pc2").read_bytes()[32 : 32 + 12 * count])
    mesh = bpy.data.meshes.new("character")
    mesh.from_pydata(
        [first[3 * i : 3 * i + 3] for i in range(count)],
        [],
        [corners[3 * i : 3 * i + 3] for i in range(faces)],
    )
    if len(uvs):
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs)
    mesh.polygons.foreach_set("use_smooth", [True] * faces)
    mesh.materials.append(make_material())
    character = bpy.data.objects.new("character", mesh)
    scene.collection.objects.link(character)
    cache = character.modifiers.new("motion", "MESH_CACHE")
    cache.cache_format = "PC2"
    cache.filepath = str(HERE / "character.pc2")
    cache.frame_start = SHOT["first_picture"]
    return character


def build():
    scene = bpy.context.scene
    for old in list(bpy.data.objects):
        bpy.data.objects.remove(old)
    scene.render.fps = max(1, round(SHOT["fps"]))
    scene.render.fps_base = scene.render.fps / SHOT["fps"]
    scene.frame_start, scene.frame_end = 0, max(0, SHOT["pictures"] - 1)
    show_colours_as_filmed(scene)
    show_film(make_camera(scene))
    make_character(scene)
    make_light(scene)
    lay_over_plate(scene)
    scene.frame_set(SHOT["first_picture"])


build()
)PY";

template <class Number>
void Append(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Autodesk's POINTCACHE2: signature, version, points, start, samples a frame, samples; positions.
std::string Pc2Of(const std::vector<PointsX3>& frames) {
  std::string bytes("POINTCACHE2\0", 12);
  Append<std::int32_t>(bytes, 1);
  Append<std::int32_t>(bytes, static_cast<std::int32_t>(frames[0].rows()));
  Append<float>(bytes, 0);
  Append<float>(bytes, 1);
  Append<std::int32_t>(bytes, SizeOf(frames));
  for (const PointsX3& points : frames)
    for (Eigen::Index v = 0; v < points.rows(); ++v)
      for (int k = 0; k < 3; ++k) Append<float>(bytes, static_cast<float>(points(v, k)));
  return bytes;
}

std::string CornersOf(const FacesX3& faces, const UvsX2& uvs, const FacesX3& uv_faces) {
  std::string bytes;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) Append<std::int32_t>(bytes, faces(f, k));
  for (Eigen::Index f = 0; f < uv_faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 2; ++c) Append<float>(bytes, static_cast<float>(uvs(uv_faces(f, k), c)));
  return bytes;
}

std::vector<double> NumbersOf(const Eigen::Matrix4d& matrix) {
  std::vector<double> numbers;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) numbers.push_back(matrix(r, c));
  return numbers;
}

std::vector<double> ListOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// In Blender's units: a sun's strength is the light on a face that is turned to it, of which a
/// white one gives back 1 / pi; a sky of strength 1 makes it white.
nlohmann::ordered_json LightNode(const BlenderLight& light) {
  const double all = light.sky + light.lamp, scale = all > 1 ? 1 / all : 1;
  const double facing = std::max(0.05, light.towards_lamp.dot(light.up));
  const bool shadow = all > 0;
  const double half = kTableSide * light.diagonal;
  nlohmann::ordered_json corners = nlohmann::ordered_json::array(),
                         harmonics = nlohmann::ordered_json::array();
  const Eigen::Vector3d right = half * light.right, back = half * light.up.cross(light.right);
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(-right - back), Eigen::Vector3d(right - back),
        Eigen::Vector3d(right + back), Eigen::Vector3d(back - right)})
    corners.push_back(ListOf(light.middle + corner));
  for (int c = 0; c < 3; ++c)
    harmonics.push_back(
        std::vector<double>(light.on_character.col(c).begin(), light.on_character.col(c).end()));
  return {{"on_character", harmonics},
          {"shadow", shadow},
          {"sky", shadow ? scale * light.sky : 1},
          {"lamp", kPi * scale * light.lamp / facing},
          {"even", shadow ? kPi * std::max(0.0, 1 - all) : 0},
          {"towards_lamp", ListOf(light.towards_lamp)},
          {"lamp_angle", 2 * light.lamp_radius_rad},
          {"table",
           {{"middle", ListOf(light.middle)},
            {"up", ListOf(light.up)},
            {"diagonal", light.diagonal},
            {"corners", corners}}}};
}

nlohmann::ordered_json CameraNode(const BlenderShot& shot, const std::vector<PointsX3>& frames) {
  const View& view = shot.view;
  const BlenderCamera camera = BlenderCameraOf(view);
  nlohmann::ordered_json path = nlohmann::ordered_json::array();
  for (const View& place : shot.path)
    path.push_back(NumbersOf(BlenderCameraOf(place).matrix_world));
  double farthest = 0;
  for (Eigen::Index v = 0; v < frames[0].rows(); ++v)
    farthest = std::max(farthest, (view.camera_from_world * Eigen::Vector3d(frames[0].row(v))).z());
  return {{"width", view.camera.width},
          {"height", view.camera.height},
          {"sensor_width_mm", camera.sensor_width_mm},
          {"lens_mm", camera.lens_mm},
          {"shift_x", camera.shift_x},
          {"shift_y", camera.shift_y},
          {"pixel_aspect_y", camera.pixel_aspect_y},
          {"clip_start", 1e-3 * farthest},
          {"clip_end", 100 * farthest},
          {"matrix_world", NumbersOf(camera.matrix_world)},
          {"path", path}};
}

}  // namespace

BlenderCamera BlenderCameraOf(const View& view) {
  const Camera& c = view.camera;
  BlenderCamera blender;
  blender.lens_mm = c.fx * blender.sensor_width_mm / c.width;
  blender.pixel_aspect_y = c.fx / c.fy;
  blender.shift_x = 0.5 - c.cx / c.width;
  blender.shift_y = (c.cy - 0.5 * c.height) * blender.pixel_aspect_y / c.width;
  const Rigid3 world_from_camera = view.camera_from_world.Inverse();
  blender.matrix_world.setIdentity();
  blender.matrix_world.topLeftCorner<3, 3>() =
      world_from_camera.rotation.toRotationMatrix() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  blender.matrix_world.topRightCorner<3, 1>() = world_from_camera.translation;
  return blender;
}

std::vector<BlenderFile> BlenderFiles(const BlenderShot& shot, const FacesX3& faces,
                                      const UvsX2& uvs, const FacesX3& uv_faces,
                                      const std::vector<PointsX3>& frames) {
  nlohmann::ordered_json root = {{"schema", 1},
                                 {"fps", shot.fps},
                                 {"first_picture", shot.first_picture},
                                 {"pictures", shot.pictures},
                                 {"vertices", frames[0].rows()},
                                 {"faces", faces.rows()},
                                 {"textures", shot.textures},
                                 {"plate", shot.plate},
                                 {"film", shot.film}};
  root["camera"] = CameraNode(shot, frames);
  root["light"] = shot.light ? LightNode(*shot.light) : nlohmann::ordered_json();
  return {{"shot.py", kScript},
          {"shot.json", root.dump(1) + "\n"},
          {"character.bin", CornersOf(faces, uvs, uv_faces)},
          {"character.pc2", Pc2Of(frames)}};
}

}  // namespace keypose::composite
