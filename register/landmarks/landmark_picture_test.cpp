#include "register/landmarks/landmark_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::registration::landmark_picture_test {

TEST(DrawLandmarks, ShowsAMarkOnlyWhereItCanBeSeen) {
  const Mesh ball = MakeIcosphere(3);
  LandmarkPictureOptions options;
  options.panel = 120;
  const DrawnPair front{
      {0, -1, 0}, {0, -1, 0}, false};  // visible in the first view, hidden in the third
  const Image8 without = DrawLandmarks(ball, ball, {}, {}, options),
               with = DrawLandmarks(ball, ball, {front}, {}, options);
  ASSERT_EQ(with.data.size(), without.data.size());
  std::vector<int> changed(4, 0);
  for (int y = 0; y < with.height; ++y)
    for (int x = 0; x < with.width; ++x)
      if (!std::equal(with.at(x, y), with.at(x, y) + 3, without.at(x, y)))
        ++changed[std::min(3, 4 * x / with.width)];
  EXPECT_GT(changed[0], 40);
  EXPECT_EQ(changed[2], 0);
  EXPECT_THROW(DrawLandmarks(ball, ball, {}, {1, 2}, options), InputError);
  options.panel = 10;
  EXPECT_THROW(DrawLandmarks(ball, ball, {}, {}, options), InputError);
}

/// Number of pixels in rows [y0, y1) with the colour of the first mark.
int MarkPixels(const Image8& image, int y0, int y1) {
  int count = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t* p = image.at(x, y);
      count += p[0] == 230 && p[1] == 30 && p[2] == 30;
    }
  return count;
}

TEST(DrawLandmarks, APairThatNoSideShowsGetsAColumnOfItsOwnInBothRows) {
  const Mesh ball = MakeIcosphere(3);
  LandmarkPictureOptions options;
  options.panel = 120;
  const Image8 plain = DrawLandmarks(ball, ball, {}, {}, options);
  // On the source it is visible in the first view. On the target it is at the bottom, where no view
  // from above sees it.
  const Image8 image = DrawLandmarks(ball, ball, {{{0, -1, 0}, {0, 0, -1}, false}}, {}, options);
  ASSERT_GT(image.height, plain.height + 200);
  EXPECT_GT(MarkPixels(image, 0, 120), 20);
  EXPECT_EQ(MarkPixels(image, 124, plain.height), 0);
  EXPECT_GT(MarkPixels(image, plain.height + 4, plain.height + 124), 20);
  EXPECT_GT(MarkPixels(image, plain.height + 128, image.height), 20);
}

TEST(DrawLandmarks, MeshesAreInTheirOwnColours) {
  Mesh red = MakeIcosphere(3);
  red.colors = ColorsX3::Zero(red.vertex_count(), 3);
  red.colors.col(0).setConstant(200);
  LandmarkPictureOptions options;
  options.panel = 120;
  const Image8 image = DrawLandmarks(
      red, red, {}, std::vector<int>(static_cast<std::size_t>(red.vertex_count()), 0), options);
  for (const int y : {60, 184})
    EXPECT_GT(image.at(60, y)[0], 3 * image.at(60, y)[1]) << "row at " << y;
}

}  // namespace keypose::registration::landmark_picture_test
