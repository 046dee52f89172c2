#include "export/fbx/fbx_error.h"

#include <gtest/gtest.h>

#include "export/caches/testing/test_scene.h"
#include "export/fbx/fbx.h"

namespace keypose::exporting::fbx_error_test {

std::string BytesOf(const Scene& scene) { return MakeFbx(scene, nullptr).files.at(0).bytes; }

TEST(FbxErrorOverDiagonal, IsTheDistanceByWhichAFrameIsOff) {
  Scene scene = TestScene();
  const std::string bytes = BytesOf(scene);
  const double diagonal = SceneDiagonal(scene);
  scene.frames[2].points.row(17) += Eigen::RowVector3d(0.03, 0, -0.04) * diagonal;
  EXPECT_NEAR(FbxErrorOverDiagonal(bytes, scene, nullptr), 0.05, 1e-6);
}

TEST(FbxErrorOverDiagonal, SeesAFrameThatComesTooLate) {
  TestSceneOptions options;
  const std::string bytes = BytesOf(TestScene(options));
  options.playback.fps = 5;
  EXPECT_GT(FbxErrorOverDiagonal(bytes, TestScene(options), nullptr), 0.01);
}

}  // namespace keypose::exporting::fbx_error_test
