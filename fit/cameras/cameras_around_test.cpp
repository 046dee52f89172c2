// Cameras that no rig knows are found from all sides of the template.
#include "fit/cameras/cameras_around.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "fit/cameras/testing/photographed_figure.h"

namespace keypose::fit::cameras_around_test {

TEST_F(CamerasAround, EachPhotographsIsFoundExactlyWithoutAnyMatchOfItsOwn) {
  const std::vector<PreparedView> views = {Photograph(8, 34), Photograph(113, 12),
                                           Photograph(262, 50)};
  const auto cameras = FindCamerasAround(mesh_, texture_, views, std::vector<FoundCamera>(3));
  for (int v = 0; v < 3; ++v) {
    ASSERT_TRUE(cameras[v].found) << v;
    EXPECT_LT(Off(cameras[v].camera_from_world, views[v]), 0.02) << v;
    EXPECT_EQ(cameras[v].inliers, static_cast<int>(cameras[v].agreeing.size()));
  }
}

TEST_F(CamerasAround, AWrongCameraDoesNotStay) {
  const std::vector<PreparedView> views = {Photograph(8, 34)};
  std::vector<FoundCamera> wrong(1);
  wrong[0].found = true;
  wrong[0].camera_from_world = Photograph(188, 34).camera_from_world;
  const auto cameras = FindCamerasAround(mesh_, texture_, views, wrong);
  ASSERT_TRUE(cameras[0].found);
  EXPECT_LT(Off(cameras[0].camera_from_world, views[0]), 0.02);
}

TEST_F(CamerasAround, NothingIsFoundOfAnotherFigure) {
  const std::vector<PreparedView> views = {Photograph(8, 34)};
  Image8 other(texture_.width, texture_.height, 3);
  for (int y = 0; y < other.height; ++y)
    for (int x = 0; x < other.width; ++x)
      for (int c = 0; c < 3; ++c)
        other.at(x, y)[c] = texture_.at(other.width - 1 - x, other.height - 1 - y)[c];
  EXPECT_FALSE(FindCamerasAround(mesh_, other, views, std::vector<FoundCamera>(1))[0].found);
}

TEST_F(CamerasAround, PicksTellThePlaceOnAPlainBall) {
  mesh_.points = MakeIcosphere(4).points;  // as a mask the same from all sides
  texture_ = Image8(64, 64, 3, 128);
  const std::vector<PreparedView> views = {Photograph(8, 34)};
  FoundCamera picked;
  for (int vertex = 0; vertex < mesh_.points.rows(); vertex += 211) {
    const Eigen::Vector3d x = mesh_.points.row(vertex);
    if (x.dot(views[0].Center().normalized()) < 0.5) continue;  // behind, or near the rim
    const Eigen::Vector3d seen = views[0].camera_from_world * x;
    picked.picks.push_back({{Eigen::Vector3i::Constant(vertex)}, views[0].camera().Project(seen)});
  }
  picked.picks.resize(std::min<std::size_t>(picked.picks.size(), 5));
  ASSERT_GE(picked.picks.size(), 4u);
  EXPECT_FALSE(FindCamerasAround(mesh_, texture_, views, {FoundCamera{}})[0].found);
  const FoundCamera found = FindCamerasAround(mesh_, texture_, views, {picked})[0];
  ASSERT_TRUE(found.found);
  EXPECT_LT(Off(found.camera_from_world, views[0]), 0.02);
}

TEST_F(CamerasAround, SameBitsForAnyThreadCount) {
  const std::vector<PreparedView> views = {Photograph(113, 12)};
  SetThreadCount(1);
  const auto one = FindCamerasAround(mesh_, texture_, views, std::vector<FoundCamera>(1));
  SetThreadCount(3);
  const auto three = FindCamerasAround(mesh_, texture_, views, std::vector<FoundCamera>(1));
  SetThreadCount(0);
  EXPECT_EQ(one[0].camera_from_world.translation, three[0].camera_from_world.translation);
  EXPECT_EQ(one[0].matches.size(), three[0].matches.size());
}

}  // namespace keypose::fit::cameras_around_test
