#include "cleanup/repair/handle_loops.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cleanup/testing/damaged_meshes.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::handle_loops_test {

double LoopLength(const Mesh& mesh, const std::vector<int>& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (mesh.points.row(loop[i]) - mesh.points.row(loop[(i + 1) % loop.size()])).norm();
  return sum;
}

TEST(HandleLoops, SphereHasNone) { EXPECT_TRUE(HandleLoops(MakeIcosphere(2)).empty()); }

TEST(HandleLoops, ShortestOfATorusGoesRoundItsTube) {
  const Mesh torus = MakeTorus(1, 0.35, 60, 24);
  const auto loops = HandleLoops(torus);
  ASSERT_GE(loops.size(), 2u);
  EXPECT_NEAR(LoopLength(torus, loops[0]), 2 * 24 * 0.35 * std::sin(EIGEN_PI / 24), 1e-9);
}

}  // namespace keypose::cleanup::handle_loops_test
