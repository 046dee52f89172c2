#include "texture/bake/lattice.h"

#include <gtest/gtest.h>

#include "core/values/size_of.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::lattice_test {

TEST(FaceLattice, GivesLinearFunctionsBackAndCutsTheTriangleWithoutGaps) {
  const auto linear = [](const Vector3f& w) { return 3 * w[0] - 2 * w[1] + 7 * w[2]; };
  for (const int parts : {1, 2, 5, 16}) {
    const FaceLattice lattice(parts);
    std::vector<float> values;
    lattice.ForNodes([&](const Vector3f& w) { values.push_back(linear(w)); });
    ASSERT_EQ(SizeOf(values), FaceLattice::CountOf(parts));
    // Corners, sides, nodes, and points a rounding outside are among these.
    for (int i = 0; i <= 60; ++i)
      for (int j = 0; i + j <= 60; ++j) {
        const Vector3f w(static_cast<float>(60 - i - j) / 60 + (i == 0 ? 1e-6f : 0),
                         static_cast<float>(i) / 60 - (i == 0 ? 1e-6f : 0),
                         static_cast<float>(j) / 60);
        const FaceLattice::Corners at = lattice.Between(w);
        float value = 0, sum = 0;
        for (int k = 0; k < 3; ++k) {
          ASSERT_GE(at.weight[k], -1e-6f);
          sum += at.weight[k];
          value += at.weight[k] * values[at.node[k]];
        }
        ASSERT_NEAR(sum, 1, 1e-5);
        ASSERT_NEAR(value, linear(w), 1e-4) << parts << " " << w.transpose();
      }
  }
}

}  // namespace keypose::texture::lattice_test
