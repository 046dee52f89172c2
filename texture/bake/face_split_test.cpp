#include "texture/bake/face_split.h"

#include <gtest/gtest.h>

#include "core/surfaces/geometry.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::face_split_test {

TEST(SplitLargeFaces, KeepsTheSurfaceAndItsLayout) {
  const Mesh mesh = PatchSphere(3);
  const std::vector<View> views = AllRound(240);
  const Mesh split = SplitLargeFaces(mesh, views);
  ASSERT_GT(split.face_count(), mesh.face_count());
  EXPECT_TRUE(CheckClosed(split).closed());
  EXPECT_NEAR(SurfaceArea(split.points, split.faces), SurfaceArea(mesh.points, mesh.faces), 1e-9);
  const Atlas before = RasterizeAtlas(mesh, 128), after = RasterizeAtlas(split, 128);
  for (std::size_t t = 0; t < before.face.size(); ++t) {
    ASSERT_EQ(before.inside[t], after.inside[t]);
    if (!before.inside[t]) continue;
    Vector3d x = Vector3d::Zero(), y = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      x += static_cast<double>(before.Weights(t)[k]) *
           mesh.points.row(mesh.faces(before.face[t], k)).transpose();
      y += static_cast<double>(after.Weights(t)[k]) *
           split.points.row(split.faces(after.face[t], k)).transpose();
    }
    ASSERT_LT((x - y).norm(), 1e-5);
  }
}

}  // namespace keypose::texture::face_split_test
