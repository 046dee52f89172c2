#include "armature/live/puppet_files.h"

#include <gtest/gtest.h>

#include "armature/description/chain_file.h"
#include "armature/description/description_file.h"
#include "armature/live/testing/theropod_parts.h"
#include "armature/testing/theropods.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/shot_io.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"

namespace keypose::armature::puppet_files_test {

FilmedShot MovingShot(const std::vector<int>& located) {
  FilmedShot shot;
  shot.camera.width = shot.camera.height = 8;
  shot.camera.fx = shot.camera.fy = 8;
  shot.camera.cx = shot.camera.cy = 4;
  shot.still = false;
  for (const int number : located) {
    ShotFrame frame;
    frame.frame = number;
    frame.picture = "p.png";
    frame.method = "features";
    frame.camera_from_world.translation = Eigen::Vector3d(number, 0, 5);
    shot.frames.push_back(frame);
  }
  return shot;
}

TEST(PlateFiles, APlateHasTheCameraOfTheFrameThatWasLocatedNearestToIt) {
  const TestingFolder folder;
  const auto shot = folder.Put("shot.json", ShotText(MovingShot({0, 1, 4})));  // 2, 3: left out
  const auto plates = folder.path() / "plates";
  std::filesystem::create_directories(plates);
  for (const char* name : {"0100.png", "0101.png", "0102.png", "0103.png", "0104.png"})
    WriteImage(plates / name, Image8(8, 8, 3));
  const PointsX3 rest = MakeIcosphere(1).points;
  for (const auto& given : {plates, std::filesystem::path()}) {
    const PlateFiles files(given, shot, rest);
    ASSERT_EQ(files.count(), 5);
    std::vector<double> at;
    for (const PlateView& view : files.views())
      at.push_back(view.view.camera_from_world.translation.x());
    EXPECT_EQ(at, (std::vector<double>{0, 1, 1, 4, 4}));
  }
}

TEST(LoadPuppet, AMeshThatIsNotWhereItsSkeletonIsIsToldOf) {
  const TestingFolder folder;
  const Armature theropod = MakeTheropod();
  PuppetPaths paths;
  paths.description = folder.Put("t.txt", DescriptionText(theropod));
  paths.chains = folder.Put("c.txt", ChainsText(theropod, MakeTheropodChains(theropod)));
  paths.skeleton = folder.path() / "t.bvh";
  paths.mesh = folder.path() / "t.ply";
  WriteBvh(paths.skeleton, MakeTheropodSkeleton());
  Mesh body = MakeTheropodBody(1000);
  WriteMesh(paths.mesh, body);
  EXPECT_EQ(LoadPuppet(paths, {}).misplaced, "");
  const PointsX3 right = body.points;
  body.points.col(1).array() += 2 * BoundingDiagonal(right);
  WriteMesh(paths.mesh, body);
  EXPECT_NE(LoadPuppet(paths, {}).misplaced.find("lie outside of the mesh"), std::string::npos);
  body.points = 1000 * right;
  WriteMesh(paths.mesh, body);
  EXPECT_NE(LoadPuppet(paths, {}).misplaced.find("times as large"), std::string::npos);
}

}  // namespace keypose::armature::puppet_files_test
