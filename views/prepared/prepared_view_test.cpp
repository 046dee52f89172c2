#include "views/prepared/prepared_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/values/errors.h"

namespace keypose::prepared_view_test {

TEST(PrepareView, NamesTheImageWhoseSizeIsWrong) {
  View view;
  view.name = "IMG_7.jpg";
  view.camera = {.width = 100, .height = 80, .fx = 100, .fy = 100, .cx = 50, .cy = 40};
  try {
    PrepareView(view, 0, Image8(90, 80, 3), Image8(90, 80, 1), 1, 1);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("IMG_7.jpg"), std::string::npos);
  }
  EXPECT_THROW(PrepareView(view, 0, Image8(100, 80, 3), Image8(100, 81, 1), 1, 1), InputError);
  const PreparedView empty = PrepareView(view, 0, Image8(100, 80, 3), Image8(100, 80, 1), 1, 1);
  EXPECT_EQ(empty.masked_pixels, 0);
  EXPECT_TRUE(empty.levels.empty());
}

TEST(PrepareView, UndistortsScalesAndCrops) {
  // A bright dot placed by the distorted camera is found where the undistorted camera projects it.
  View view;
  view.camera = {.width = 400,
                 .height = 300,
                 .fx = 380,
                 .fy = 380,
                 .cx = 203,
                 .cy = 148,
                 .k1 = -0.12,
                 .k2 = 0.03};
  const Eigen::Vector3d point(0.3, -0.2, 1);
  const Eigen::Vector2d pixel = view.camera.Project(point);
  Image8 image(400, 300, 3, 10), mask(400, 300, 1);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 400; ++x) {
      const double d2 = (Eigen::Vector2d(x + 0.5, y + 0.5) - pixel).squaredNorm();
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(10 + 200 * std::exp(-d2 / 18));
      if (d2 < 900) *mask.at(x, y) = 255;
    }
  const PreparedView out = PrepareView(view, 0, image, mask, 0.5, 2);
  ASSERT_EQ(out.levels.size(), 2u);
  EXPECT_LT(out.camera().width, 60) << "cropped to the mask";
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double total = 0;
  for (int y = 0; y < out.color.height; ++y)
    for (int x = 0; x < out.color.width; ++x) {
      const double weight = std::max(0, *out.color.at(x, y) - 12);
      sum += weight * Eigen::Vector2d(x, y), total += weight;
    }
  EXPECT_LT((sum / total - out.camera().Project(point)).norm(), 0.05);
  EXPECT_LT((0.5 * (out.camera().Project(point) - Eigen::Vector2d(0.5, 0.5)) -
             out.camera(1).Project(point))
                .norm(),
            1e-9);
}

// The lens draws the picture's sides inwards: the undistorted picture shows more than the
// photograph. A figure that the photograph cuts does not end there.
TEST(PrepareView, AMaskThatThePhotographCutsReachesTheSide) {
  View view;
  view.camera = {
      .width = 400, .height = 300, .fx = 380, .fy = 380, .cx = 200, .cy = 150, .k1 = 0.15};
  const Image8 image(400, 300, 3, 90);
  Image8 mask(400, 300, 1);
  for (int y = 100; y < 200; ++y)
    for (int x = 250; x < 400; ++x) *mask.at(x, y) = 255;
  const PreparedView out = PrepareView(view, 0, image, mask, 1, 1);
  ASSERT_EQ(out.levels.size(), 1u);
  const GreyMask& grey = out.levels[0].grey;
  EXPECT_TRUE(InMask(*grey.at(grey.width - 1, grey.height / 2)));
  EXPECT_FALSE(InMask(*grey.at(0, grey.height / 2)));
}

}  // namespace keypose::prepared_view_test
