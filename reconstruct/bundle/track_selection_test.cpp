#include "reconstruct/bundle/track_selection.h"

#include <gtest/gtest.h>

#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::track_selection_test {

TEST(SpreadPoints, KeepsTheCountAndTheObservationsOfWhatItKeeps) {
  std::vector<View> views;
  for (int k = 0; k < 6; ++k) views.push_back(testing::BallCamera(k, 6));
  const Scene scene = testing::PointsOnBall(views, 1000, 0);
  std::vector<Observation> observations;
  for (std::size_t p = 0; p < scene.points.size(); ++p)
    for (const int v : scene.points[p].views)
      observations.push_back(
          {v, static_cast<int>(p), scene.views[v].Project(scene.points[p].position)});
  const PointSet some = SpreadPoints(scene, observations, 200);
  ASSERT_EQ(some.scene.points.size(), 200U);
  for (const Observation& o : some.observations)
    EXPECT_LT(
        (some.scene.views[o.view].Project(some.scene.points[o.point].position) - o.pixel).norm(),
        1e-9);
  EXPECT_EQ(SpreadPoints(scene, observations, 5000).scene.points.size(), scene.points.size());
}

}  // namespace keypose::reconstruct::track_selection_test
