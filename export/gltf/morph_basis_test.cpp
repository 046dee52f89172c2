// Bases of shapes with known truth.
#include "export/gltf/morph_basis.h"

#include <gtest/gtest.h>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "export/gltf/testing/turning_pictures.h"

namespace keypose::exporting::morph_basis_test {

/// One vertex on the parabola y = x^2, x from -1 to 1.
std::vector<PointsX3> Parabola(int count) {
  std::vector<PointsX3> points(count, PointsX3::Zero(1, 3));
  for (int i = 0; i < count; ++i) {
    const double x = -1 + 2.0 * i / (count - 1);
    points[i].row(0) << x, x * x, 0;
  }
  return points;
}

TEST(FitMorphBasis, RigidTurnIsTwoTargets) {
  const auto points = Turning(24, 170);
  const MorphFit fit = FitMorphBasis(PicturesOf(points), 8, 1e-9, nullptr);
  EXPECT_EQ(fit.basis.targets.size(), 2u) << "cosine and sine";
  EXPECT_LT(fit.largest_error, 1e-9);
}

TEST(FitMorphBasis, LineThroughAParabolaIsTheOneWithTheSmallestLargestDistance) {
  const auto points = Parabola(41);
  const Pictures pictures = PicturesOf(points);
  const MorphFit fit = FitMorphBasis(pictures, 1, 1e-6, nullptr);
  // Least squares gives y = mean of x^2, 0.65 from the ends; y = 1/2 is 1/2 from middle and ends.
  EXPECT_NEAR(fit.largest_error, 0.5, 0.005);
  EXPECT_NEAR(VertexErrors(pictures, fit.basis)(0), fit.largest_error, 1e-12);
}

TEST(FitMorphBasis, BoundDecidesHowMany) {
  const auto points = Parabola(41);
  EXPECT_EQ(FitMorphBasis(PicturesOf(points), 8, 0.6, nullptr).basis.targets.size(), 1u)
      << "within the bound only with the least maximum";
  EXPECT_EQ(FitMorphBasis(PicturesOf(points), 8, 0.3, nullptr).basis.targets.size(), 2u);
}

TEST(FitMorphBasis, TwoPicturesAreOneTargetExactly) {
  const auto points = Turning(2, 90);
  const MorphFit fit = FitMorphBasis(PicturesOf(points), 8, 1e-9, nullptr);
  EXPECT_EQ(fit.basis.targets.size(), 1u);
  EXPECT_LT(fit.largest_error, 1e-12);
}

TEST(FitMorphBasis, SameBitsForAnyThreadCount) {
  const auto points = Turning(12, 170);
  SetThreadCount(1);
  const MorphBasis one = FitMorphBasis(PicturesOf(points), 1, 1e-9, nullptr).basis;
  SetThreadCount(4);
  const MorphBasis four = FitMorphBasis(PicturesOf(points), 1, 1e-9, nullptr).basis;
  SetThreadCount(0);
  EXPECT_EQ(one.weights, four.weights);
  EXPECT_EQ(one.base, four.base);
  EXPECT_EQ(one.targets[0], four.targets[0]);
}

TEST(LeastSquaresBasis, GivesBackABasisFromItsOwnPictures) {
  Eigen::MatrixXd weights(4, 2);
  weights << 0, 0, 1, 0, 0, 1, 0.5, 0.25;
  const MorphBasis made{
      MakeBox(1, 2, 3).points, {MakeBox(3, 1, 2).points, MakeBox(2, 2, 0.5).points}, weights};
  std::vector<PointsX3> points;
  for (int p = 0; p < 4; ++p) points.push_back(Blended(made, p));
  const MorphBasis found = LeastSquaresBasis(PicturesOf(points), weights);
  EXPECT_LT((found.base - made.base).cwiseAbs().maxCoeff(), 1e-12);
  for (int k = 0; k < 2; ++k)
    EXPECT_LT((found.targets[k] - made.targets[k]).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace keypose::exporting::morph_basis_test
