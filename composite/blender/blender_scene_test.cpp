// The camera that the script builds in Blender shows points where our camera does.
#include "composite/blender/blender_scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/pictures/fit_view.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"

namespace keypose::composite::blender_scene_test {

namespace fs = std::filesystem;

View OddView() {
  View view{"", {641, 360, 700, 721, 300.25, 201.5}, {}};
  view.camera_from_world = LookAt({1.2, -3.1, 1.4}, {0.1, 0.2, 0.3});
  return view;
}

/// A cube's corners, and faces that use them.
PointsX3 Cube() {
  PointsX3 points(8, 3);
  for (int i = 0; i < 8; ++i) points.row(i) << (i & 1) - 0.4, (i >> 1 & 1) - 0.6, (i >> 2) - 0.3;
  return points;
}

TEST(BlenderCamera, LooksAlongItsMinusZ) {
  const View view = OddView();
  const BlenderCamera camera = BlenderCameraOf(view);
  EXPECT_NEAR(camera.lens_mm, 700.0 * 36 / 641, 1e-12);
  const Eigen::Vector3d eye = camera.matrix_world.topRightCorner<3, 1>();
  EXPECT_LT((eye - view.Center()).norm(), 1e-12);
  const Eigen::Vector3d ahead = eye - camera.matrix_world.block<3, 1>(0, 2);
  EXPECT_NEAR((view.camera_from_world * ahead).z(), 1, 1e-12);
  const Eigen::Vector3d above = eye + camera.matrix_world.block<3, 1>(0, 1);
  EXPECT_NEAR((view.camera_from_world * above).y(), -1, 1e-12) << "our y points down";
}

const char* const kCheck = R"PY(
import json, pathlib, sys
import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector
here = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
scene = bpy.context.scene
bpy.context.view_layer.update()
character = bpy.data.objects["character"]
assert scene.view_settings.view_transform == "Standard"
pixels = []
for frame in (0, 1):
    scene.frame_set(SHOT_START + frame)
    mesh = character.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    for vertex in mesh.vertices:
        at = world_to_camera_view(scene, scene.camera, character.matrix_world @ vertex.co)
        pixels.append([at.x * scene.render.resolution_x, (1 - at.y) * scene.render.resolution_y])
(here / "pixels.json").write_text(json.dumps(pixels))
)PY";

TEST(BlenderScene, ShowsPointsWhereOurCameraDoes) {
  if (std::system("blender --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no Blender here";
  const TestingFolder own;
  const fs::path folder = own.path();
  const PointsX3 first = Cube();
  const PointsX3 second = first.rowwise() + Eigen::RowVector3d(0.2, 0.1, -0.05);
  FacesX3 faces(2, 3);
  faces << 0, 1, 2, 5, 6, 7;
  BlenderShot shot{OddView(), {}, 24, 3, 5, {}, "", ""};
  for (int n = 0; n < 5; ++n) {  // the camera moves on
    shot.path.push_back(OddView());
    shot.path.back().camera_from_world = LookAt({1.2 + 0.1 * n, -3.1, 1.4}, {0.1, 0.2, 0.3});
  }
  for (const BlenderFile& file : BlenderFiles(shot, faces, {}, {}, {first, second}))
    WriteFile(folder / file.name, file.bytes);
  WriteFile(folder / "check.py", "SHOT_START = 3\n" + std::string(kCheck));
  const std::string command = "blender -b --factory-startup --python-exit-code 1 --python " +
                              (folder / "shot.py").string() + " --python " +
                              (folder / "check.py").string() + " -- " + folder.string() + " > " +
                              (folder / "log.txt").string() + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(folder / "log.txt");
  const auto pixels = nlohmann::json::parse(ReadFile(folder / "pixels.json"));
  ASSERT_EQ(pixels.size(), 16u);
  for (int i = 0; i < 16; ++i) {
    const Eigen::Vector3d point = (i < 8 ? first : second).row(i % 8);
    const Eigen::Vector2d ours = shot.path[i < 8 ? 3 : 4].Project(point);
    EXPECT_NEAR(pixels[i][0], ours.x(), 1e-3) << i;
    EXPECT_NEAR(pixels[i][1], ours.y(), 1e-3) << i;
  }
}

const char* const kRender = R"PY(
import pathlib, sys
import bpy
here = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
scene = bpy.context.scene
lamp = bpy.data.objects["lamp"]
towards = lamp.matrix_world.to_quaternion() @ __import__("mathutils").Vector((0, 0, 1))
assert abs(towards.x - 0.5 ** 0.5) < 1e-5 and abs(towards.z - 0.5 ** 0.5) < 1e-5, towards
assert lamp.data.type == "SUN" and abs(lamp.data.angle - 0.04) < 1e-6
assert bpy.data.objects["table"].is_shadow_catcher
scene.cycles.samples = 24
scene.render.filepath = str(here / "f12.png")
bpy.ops.render.render(write_still=True)
)PY";

TEST(BlenderScene, F12LooksLikeTheComposite) {
  if (std::system("blender --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no Blender here";
  const TestingFolder own;
  const fs::path folder = own.path();
  Mesh box = MakeBox(0.4, 0.4, 0.4);
  box.points.leftCols(2).array() -= 0.2;
  // Straight from above; 20 pixels are a tenth.
  View view{"", {160, 120, 600, 600, 80, 60}, {}};
  view.camera_from_world = LookAt({0, -1e-4, 3}, {0, 0, 0});
  BlenderShot shot{view, {}, 24, 0, 1, {"grey.png"}, "grey.png", ""};
  BlenderLight light;
  light.on_character.setZero();
  light.on_character.row(0).setConstant(1), light.on_character.row(3).setConstant(0.5);
  light.lamp = 0.6, light.lamp_radius_rad = 0.02;
  light.towards_lamp = Eigen::Vector3d(1, 0, 1).normalized();
  light.middle.setZero(), light.right = Eigen::Vector3d::UnitX();
  light.up = Eigen::Vector3d::UnitZ();
  shot.light = light;
  const UvsX2 uvs = UvsX2::Constant(1, 2, 0.5);
  const FacesX3 uv_faces = FacesX3::Zero(box.faces.rows(), 3);
  for (const BlenderFile& file : BlenderFiles(shot, box.faces, uvs, uv_faces, {box.points}))
    WriteFile(folder / file.name, file.bytes);
  WriteImage(folder / "grey.png", Image8(160, 120, 3, 188));  // half of white's light
  WriteFile(folder / "render.py", kRender);
  const std::string command = "blender -b --factory-startup --python-exit-code 1 --python " +
                              (folder / "shot.py").string() + " --python " +
                              (folder / "render.py").string() + " -- " + folder.string() + " > " +
                              (folder / "log.txt").string() + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(folder / "log.txt");
  const Image8 picture = ReadImage(folder / "f12.png", 3);
  const auto at = [&](double x, double y, double height) {
    const Eigen::Vector2d pixel = view.Project({x, y, height});
    return int{picture.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))[1]};
  };
  EXPECT_NEAR(at(0.02, 0.01, 0.4), 224, 3) << "the texture, half as bright again to the top";
  EXPECT_NEAR(at(0.35, 0.25, 0), 188, 2) << "the plate";
  EXPECT_NEAR(at(-0.35, 0, 0), 124, 4) << "0.4 of its light";
}

}  // namespace keypose::composite::blender_scene_test
