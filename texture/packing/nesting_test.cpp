#include "texture/packing/nesting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/numbers/parallel.h"
#include "texture/packing/packing.h"
#include "texture/packing/testing/outlines.h"

namespace keypose::texture::nesting_test {

TEST(Nested, ThreeRectanglesThatTileTheSquareFillIt) {
  const std::vector<UvsX2> tiles = {Rectangle(0, 0, 0.5, 1), Rectangle(3, 3, 0.5, 0.5),
                                    Rectangle(0, 0, 0.5, 0.5)};
  const Nesting nesting = Nested(tiles, {});
  EXPECT_GT(nesting.scale, 0.97);
  EXPECT_LT(nesting.scale, 1.01);  // half a cell of overlap each
}

TEST(Nested, SearchBeatsItsBottomLeftStart) {
  std::vector<UvsX2> outlines;
  for (int i = 0; i < 14; ++i) {
    const Shape star = Star(2 + i % 5, 0.15 + 0.04 * (i % 7));
    outlines.push_back((0.4 + 0.1 * (i % 6)) * star.points.topRows(star.points.rows() - 1));
  }
  NestingOptions none;
  none.effort = 0;
  double area = 0;
  for (const UvsX2& p : outlines) area += OutlineArea(p);
  const double start = area * std::pow(Nested(outlines, none).scale, 2),
               searched = area * std::pow(Nested(outlines, {}).scale, 2);
  EXPECT_GT(searched, start + 0.02);
  EXPECT_GT(searched, 0.72);
}

TEST(Nested, SameForAnyThreadCount) {
  std::vector<UvsX2> outlines;
  for (int i = 0; i < 8; ++i) outlines.push_back(Star(3, 0.05 * i).points.topRows(24));
  SetThreadCount(1);
  const Nesting one = Nested(outlines, {});
  SetThreadCount(2);
  const Nesting two = Nested(outlines, {});
  SetThreadCount(0);
  EXPECT_EQ(one.scale, two.scale);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(one.places[i].offset, two.places[i].offset);
}

}  // namespace keypose::texture::nesting_test
