#include "core/pictures/sight_lines.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/pictures/testing/from_above.h"
#include "core/surfaces/shapes.h"

namespace keypose::sight_lines_test {

/// A ring of pixels around the middle, with background inside.
Image8 RingMask(int size, double inner, double outer) {
  Image8 mask(size, size, 1);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double r = Eigen::Vector2d(x + 0.5 - size / 2.0, y + 0.5 - size / 2.0).norm();
      mask.at(x, y)[0] = r > inner && r < outer ? 255 : 0;
    }
  return mask;
}

TEST(LinesThroughHoles, AreInTheHoleAndNotOutside) {
  const View view = FromAbove(100);
  const auto lines = LinesThroughHoles({view}, {RingMask(100, 20, 40)});
  ASSERT_GT(lines.size(), 20u);
  for (const SightLine& line : lines) {
    EXPECT_EQ(line.hole, 0);
    EXPECT_EQ(line.view, 0);
    EXPECT_LT((line.origin - view.Center()).norm(), 1e-12);
    const Eigen::Vector2d pixel = view.Project(line.origin + line.direction.normalized());
    EXPECT_LT((pixel - Eigen::Vector2d(50, 50)).norm(), 20 - 2);
  }
}

TEST(LinesThroughHoles, OutlinesWithoutHolesAndMissingMasksGiveNone) {
  EXPECT_TRUE(LinesThroughHoles({FromAbove(100)}, {RingMask(100, -1, 40)}).empty());
  EXPECT_TRUE(LinesThroughHoles({FromAbove(100)}, {Image8()}).empty());
}

TEST(ClosedHoles, AreThoseThatTheSurfaceBlocksAltogether) {
  const std::vector<View> views = {FromAbove(100), FromAbove(100)};
  const auto lines = LinesThroughHoles(views, {RingMask(100, 20, 40), RingMask(100, 20, 40)});
  EXPECT_EQ(ClosedHoles(MakeIcosphere(3), lines), (std::vector<int>{0, 1}));
  EXPECT_EQ(ViewsWithClosedWindow(MakeIcosphere(3), lines), (std::vector<int>{0, 1}));
  Mesh aside = MakeIcosphere(3);
  aside.points.col(0).array() += 1;  // hides half of each hole
  EXPECT_TRUE(ClosedHoles(aside, lines).empty());
}

}  // namespace keypose::sight_lines_test
