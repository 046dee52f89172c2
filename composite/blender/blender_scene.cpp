#include "composite/blender/blender_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/parallel.h"
#include "core/size_of.h"

namespace keypose::composite {
namespace {

/// Builds the scene in Blender; reads the files beside it.
constexpr const char* kScript =
    R"PY("""Builds this shot in Blender: its camera, the film behind it, and the character.

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
        # The texture holds the light of the photographs, and the scene has no lamp. To light it
        # anew, join the Principled BSDF to the Material Output.
        glow = nodes.new("ShaderNodeEmission")
        links.new(texture.outputs["Color"], glow.inputs["Color"])
        links.new(glow.outputs["Emission"], nodes["Material Output"].inputs["Surface"])
    return material


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

Image8 Undistorted(const Image8& picture, const Camera& camera) {
  Image8 flat(picture.width, picture.height, picture.channels);
  ParallelFor(picture.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < picture.width; ++x) {
      const Eigen::Vector2d from =
          camera.Project({(x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1});
      const double px = std::clamp(from.x() - 0.5, 0.0, picture.width - 1.0),
                   py = std::clamp(from.y() - 0.5, 0.0, picture.height - 1.0);
      const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
      const int x1 = std::min(x0 + 1, picture.width - 1), y1 = std::min(y0 + 1, picture.height - 1);
      const double fx = px - x0, fy = py - y0;
      for (int c = 0; c < picture.channels; ++c)
        flat.at(x, y)[c] = static_cast<std::uint8_t>(
            std::lround((1 - fy) * ((1 - fx) * picture.at(x0, y0)[c] + fx * picture.at(x1, y0)[c]) +
                        fy * ((1 - fx) * picture.at(x0, y1)[c] + fx * picture.at(x1, y1)[c])));
    }
  });
  return flat;
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
  return {{"shot.py", kScript},
          {"shot.json", root.dump(1) + "\n"},
          {"character.bin", CornersOf(faces, uvs, uv_faces)},
          {"character.pc2", Pc2Of(frames)}};
}

}  // namespace keypose::composite
