#include "views/hull/view_selection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "views/hull/depth_bounds.h"
#include "views/hull/testing/ball_ring.h"
#include "views/hull/visual_hull.h"

namespace keypose::view_selection_test {

TEST(ViewSelection, RingNeighboursComeFirstWhateverTheOrderOfFiles) {
  std::vector<PreparedView> views = BallRing(30, 6, 20);
  std::swap(views[4], views[17]);
  const VisualHull hull = CarveVisualHull(views, VisualHullOptions{});
  std::vector<DepthBounds> bounds;
  for (const PreparedView& view : views) bounds.push_back(HullDepthBounds(hull, view));
  const std::vector<std::vector<int>> sources = SelectSourceViews(views, bounds, Scene{}, 6);
  for (std::size_t i = 0; i < views.size(); ++i) {
    ASSERT_EQ(sources[i].size(), 6u);
    for (const int s : sources[i]) {
      const double cosine = views[i].Center().normalized().dot(views[s].Center().normalized());
      EXPECT_LT(std::acos(cosine) * 180 / M_PI, 37) << "12 degrees a step: three on each side";
    }
  }
}

}  // namespace keypose::view_selection_test
