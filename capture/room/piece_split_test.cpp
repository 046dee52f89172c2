#include "capture/room/piece_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "capture/room/testing/figure_on_book.h"

namespace keypose::capture::piece_split_test {

TEST(OtherPart, IsCutAtTheNarrowPlace) {
  // Two squares of one colour, joined by one point.
  constexpr int kSide = 9;
  ColouredSurface surface;
  const auto at = [](int square, int x, int y) { return square * kSide * kSide + y * kSide + x; };
  surface.colours.assign(2 * kSide * kSide, Eigen::Vector3f(90, 90, 90));
  surface.neighbours.resize(surface.colours.size());
  const auto join = [&surface](int a, int b) {
    surface.neighbours[static_cast<std::size_t>(a)].push_back(b);
    surface.neighbours[static_cast<std::size_t>(b)].push_back(a);
  };
  for (int square = 0; square < 2; ++square)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        if (x > 0) join(at(square, x, y), at(square, x - 1, y));
        if (y > 0) join(at(square, x, y), at(square, x, y - 1));
      }
  join(at(0, kSide - 1, 4), at(1, 0, 4));
  const std::vector<char> other = OtherPart(surface, {at(0, 3, 4)}, {at(1, 2, 4)});
  for (int i = 0; i < 2 * kSide * kSide; ++i) EXPECT_EQ(other[i], i >= kSide * kSide) << i;
}

TEST(OtherPart, IsCutWhereTheColourChanges) {
  ColouredSurface line;
  for (int i = 0; i < 40; ++i) {
    line.colours.push_back(Eigen::Vector3f::Constant(i < 30 ? 60 : 200));
    line.neighbours.emplace_back();
    if (i == 0) continue;
    line.neighbours[static_cast<std::size_t>(i)].push_back(i - 1);
    line.neighbours[static_cast<std::size_t>(i) - 1].push_back(i);
  }
  const std::vector<char> other = OtherPart(line, {2}, {35});
  for (int i = 0; i < 40; ++i) EXPECT_EQ(other[i], i >= 30) << i;
}

TEST(BorderOf, SmallPartsOfOneColourCostMore) {
  // A strip, one point wide; its last ten points have another colour.
  ColouredSurface strip;
  for (int i = 0; i < 40; ++i) {
    strip.colours.push_back(Eigen::Vector3f::Constant(i < 30 ? 60 : 200));
    strip.neighbours.emplace_back();
    if (i > 0) strip.neighbours.back().push_back(i - 1);
    if (i < 39) strip.neighbours.back().push_back(i + 1);
  }
  const auto last = [](int count) {
    std::vector<char> part(40, 0);
    std::fill(part.end() - count, part.end(), 1);
    return part;
  };
  EXPECT_LT(BorderOf(strip, last(10)), 0.1 * BorderOf(strip, last(8)));
  EXPECT_NEAR(BorderOf(strip, last(2)), 2 * BorderOf(strip, last(8)), 1e-6);
  EXPECT_NEAR(BorderOf(strip, last(38)), BorderOf(strip, last(2)), 1e-6);
  EXPECT_EQ(BorderOf(strip, last(0)), kFar);
}

TEST(OtherPart, FollowsThePlaceWhereNeitherWidthNorColourTells) {
  // A strip of one colour and width; the line was drawn round its end.
  ColouredSurface strip;
  for (int i = 0; i < 40; ++i) {
    strip.colours.push_back(Eigen::Vector3f::Constant(90));
    strip.neighbours.emplace_back();
    strip.lean.push_back(static_cast<float>(std::max(-1.0, (i - 24.5) / 10)));
    if (i == 0) continue;
    strip.neighbours[static_cast<std::size_t>(i)].push_back(i - 1);
    strip.neighbours[static_cast<std::size_t>(i) - 1].push_back(i);
  }
  const std::vector<char> other = OtherPart(strip, {2}, {38});
  for (int i = 0; i < 40; ++i) EXPECT_EQ(other[i], i >= 25) << i;
}

}  // namespace keypose::capture::piece_split_test
