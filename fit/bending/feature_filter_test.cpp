#include "fit/bending/feature_filter.h"

#include <gtest/gtest.h>

#include "core/pictures/fit_view.h"
#include "fit/bending/testing/turned_ring.h"

namespace keypose::fit::feature_filter_test {

TEST(ConsistentMatches, KeepsThoseThatABentSheetAllows) {
  const PointsX3 points = Patch();
  const Rigid3 pose = LookAt({1, -3, 5}, {0, 0, 0});
  const std::vector<FeatureMatch> matches = PlaneMatches(points, pose);
  const std::vector<int> kept =
      ConsistentMatches(points, matches, kCamera, pose.translation.norm());
  int wrong = 0;
  for (const int i : kept) wrong += i % 5 == 0;
  EXPECT_GT(kept.size(), 300u);  // of 320
  EXPECT_LT(wrong, 8);           // of 80
}

TEST(SmoothMatches, RemovesThoseThatMoveUnlikeTheirNeighbours) {
  const PointsX3 points = Patch();
  const Rigid3 pose = LookAt({1, -3, 5}, {0, 0, 0});
  const std::vector<FeatureMatch> matches = PlaneMatches(points, pose);
  std::vector<Eigen::Vector2d> shown;  // the mesh is 10 pixels beside
  for (int i = 0; i < points.rows(); ++i)
    shown.push_back(kCamera.Project(pose * points.row(i).transpose()) + Eigen::Vector2d(10, 0));
  int wrong = 0;
  const std::vector<int> kept = SmoothMatches(points, matches, shown);
  for (const int i : kept) wrong += i % 5 == 0;
  EXPECT_EQ(kept.size() - wrong, 320u);
  EXPECT_LE(wrong, 1);
}

}  // namespace keypose::fit::feature_filter_test
