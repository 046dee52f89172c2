#include "export/gltf/minimax_basis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "export/gltf/testing/turning_pictures.h"

namespace keypose::exporting::minimax_basis_test {

TEST(MinimaxBasis, IsNeverWorseThanItsStart) {
  const auto points = Turning(24, 170);
  const Pictures pictures = PicturesOf(points);
  for (const double lean : {0.0, 0.3, 1.0}) {
    Eigen::MatrixXd weights(24, 1);
    for (int p = 0; p < 24; ++p) weights(p, 0) = lean * p / 23 + (1 - lean) * std::sin(p);
    const MorphBasis start = LeastSquaresBasis(pictures, weights);
    const MorphBasis better = MinimaxBasis(pictures, start, 0, nullptr);
    EXPECT_LE(VertexErrors(pictures, better).maxCoeff(), VertexErrors(pictures, start).maxCoeff());
  }
}

}  // namespace keypose::exporting::minimax_basis_test
