#include "motion/video3d/filmed_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/video3d/testing/seen_ball.h"

namespace keypose::motion::filmed_view_test {

using Eigen::Vector3d;
using Eigen::Vector3f;

TEST(DistanceToEdges, IsChamferDistance) {
  Image8 edges(9, 9, 1, 0);
  *edges.at(4, 4) = 1;
  const ImageF d = DistanceToEdges(edges, 20);
  EXPECT_EQ(*d.at(4, 4), 0);
  EXPECT_EQ(*d.at(7, 4), 3);
  EXPECT_NEAR(*d.at(6, 6), 2 * std::sqrt(2.0), 1e-6);
  EXPECT_EQ(*DistanceToEdges(edges, 2).at(0, 0), 2);
}

struct SeenWalls : ::testing::Test {
  Mesh scene = Joined(Wall(0, 1), Wall(-1, 0.2));
  View view = Straight(4, 200);
  Image8 picture{200, 200, 3, 128};
  Vector3f normal{0, -1, 0};
  FilmedView Film(const Image8& mask) const {
    return FilmedView(view, picture, mask, scene.points, scene.faces, {2, 4});
  }
};

TEST_F(SeenWalls, HiddenPlacesAndEdgesAreNotTrusted) {
  const FilmedView film = Film({});
  EXPECT_EQ(film.See({0.8f, 0, 0}, normal).trust, 1);
  EXPECT_NEAR(film.See({0.8f, 0, 0}, normal).color[0], 0.2158f, 1e-3f);  // of sRGB 128
  EXPECT_EQ(film.See({0, 0, 0}, normal).trust, 0) << "behind the small wall";
  EXPECT_EQ(film.See({0, -1, 0}, normal).trust, 1);
  EXPECT_EQ(film.See({0.195f, -1, 0}, normal).trust, 0) << "at the small wall's edge";
  const float near_edge = film.See({0.2f * 4 / 3 + 0.07f, 0, 0}, normal).trust;
  EXPECT_GT(near_edge, 0) << "feathered";
  EXPECT_LT(near_edge, 1);
  EXPECT_EQ(film.See({0.8f, 0, 0}, -normal).facing, 0);
}

TEST_F(SeenWalls, MaskHidesWhatItDoesNotHave) {
  Image8 mask(200, 200, 1, 255);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 80; ++x) *mask.at(x, y) = 0;
  const FilmedView film = Film(mask);
  EXPECT_EQ(film.See({-0.8f, 0, 0}, normal).trust, 0);
  EXPECT_EQ(film.See({0.8f, 0, 0}, normal).trust, 1);
  EXPECT_LT(film.covered_by_mask(), 0.75);
}

TEST_F(SeenWalls, NoPictureSeesNothing) {
  const FilmedView film(view, {}, {}, scene.points, scene.faces, {});
  EXPECT_TRUE(film.sees_nothing());
  EXPECT_EQ(film.See({0.8f, 0, 0}, normal).trust, 0);
}

}  // namespace keypose::motion::filmed_view_test
