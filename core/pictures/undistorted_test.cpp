#include "core/pictures/undistorted.h"

#include <gtest/gtest.h>

namespace keypose::undistorted_test {

TEST(Undistorted, StraightensWhatTheLensBent) {
  const Camera pinhole{641, 360, 700, 721, 300.25, 201.5};
  Camera bent = pinhole;
  bent.k1 = -0.12, bent.p1 = 1e-3;
  // A spot where the bent camera shows a point; the straight one shows it elsewhere.
  const Eigen::Vector3d point(0.3, -0.15, 1);
  const Eigen::Vector2d at = bent.Project(point), straight = Pinhole(bent).Project(point);
  Image8 picture(641, 360, 1);
  for (int y = 0; y < 360; ++y)
    for (int x = 0; x < 641; ++x)
      *picture.at(x, y) = (Eigen::Vector2d(x + 0.5, y + 0.5) - at).norm() < 3 ? 255 : 0;
  const Image8 flat = Undistorted(picture, bent);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double sum = 0;
  for (int y = 0; y < 360; ++y)
    for (int x = 0; x < 641; ++x)
      mean += *flat.at(x, y) * Eigen::Vector2d(x + 0.5, y + 0.5), sum += *flat.at(x, y);
  EXPECT_GT((straight - at).norm(), 2);
  EXPECT_LT((mean / sum - straight).norm(), 0.25);
}

}  // namespace keypose::undistorted_test
