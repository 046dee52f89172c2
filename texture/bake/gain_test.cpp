#include "texture/bake/gain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "texture/bake/bake.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::gain_test {

TEST(HarmonizeGains, FindsOneAndOnePointTwo) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = {At({4, 0, 0}, 240), At({3, 2.6, 0}, 240)};
  std::vector<Photograph> photographs = Shoot(mesh, {views[0]}, Smooth);
  photographs.push_back(Shoot(mesh, {views[1]}, [](const Vector3d& x, const Vector3d& eye) {
    return (1.2f * Smooth(x, eye)).eval();
  })[0]);
  const BakeResult result = BakeAll(mesh, views, photographs);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(result.gains[0][k] / result.gains[1][k], 1.2, 0.012);
    EXPECT_NEAR(result.gains[0][k] * result.gains[1][k], 1, 0.02);  // exposed between the two
  }
}

}  // namespace keypose::texture::gain_test
