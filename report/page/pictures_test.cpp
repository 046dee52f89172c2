#include "report/page/pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/testing/minimal_report.h"

namespace keypose::report::pictures_test {

TEST(MaskTile, DarkensWhatTheMaskLeavesOut) {
  Image8 photograph(6, 6, 3, 200), mask(6, 6, 1, 0);
  for (int y = 1; y < 5; ++y)
    for (int x = 1; x < 5; ++x) *mask.at(x, y) = 255;
  const Image8 tile = MaskTile(photograph, mask);
  EXPECT_EQ(tile.at(0, 0)[0], 80);
  EXPECT_EQ(tile.at(2, 2)[0], 200);
  EXPECT_EQ(tile.at(1, 2)[1], 140);  // the outline
}

TEST(HeatSides, FarVerticesGetTheHotEndOfTheScale) {
  SidesOptions options;
  options.azimuths_deg = {0};
  options.width = options.height = 60;
  const Mesh mesh = Tetrahedron();
  const Image8 cold = HeatSides(mesh, Eigen::VectorXd::Zero(4), 1, options)[0].image,
               hot = HeatSides(mesh, Eigen::VectorXd::Ones(4), 1, options)[0].image;
  EXPECT_GT(cold.at(25, 38)[2], cold.at(25, 38)[0]);
  EXPECT_GT(hot.at(25, 38)[0], hot.at(25, 38)[2]);
}

}  // namespace keypose::report::pictures_test
