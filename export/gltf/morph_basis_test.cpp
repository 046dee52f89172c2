// Bases of shapes with known truth.
#include "export/gltf/morph_basis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "export/gltf/minimax_basis.h"
#include "export/gltf/unit_weights.h"

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

/// A rigid turn about z by `degrees` in all.
std::vector<PointsX3> Turning(int count, double degrees) {
  const PointsX3 rest = MakeBox(1, 2, 3).points;
  std::vector<PointsX3> points(count, rest);
  for (int i = 0; i < count; ++i) {
    const double angle = degrees * std::numbers::pi / 180 * i / (count - 1);
    points[i].col(0) = std::cos(angle) * rest.col(0) - std::sin(angle) * rest.col(1);
    points[i].col(1) = std::sin(angle) * rest.col(0) + std::cos(angle) * rest.col(1);
  }
  return points;
}

Pictures PicturesOf(const std::vector<PointsX3>& points) {
  Pictures pictures;
  for (const PointsX3& one : points) pictures.push_back(&one);
  return pictures;
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

/// The basis gives the same pictures as before, with weights in [0, 1].
void ExpectSamePictures(const MorphBasis& before, const MorphBasis& after) {
  for (Eigen::Index p = 0; p < before.weights.rows(); ++p)
    EXPECT_LT((Blended(before, p) - Blended(after, p)).cwiseAbs().maxCoeff(), 1e-12) << p;
  EXPECT_GE(after.weights.minCoeff(), 0);
  EXPECT_LE(after.weights.maxCoeff(), 1);
}

TEST(MakeUnitWeights, PartOfATurnStartsAtTheFirstPicture) {
  const auto points = Turning(24, 170);
  const MorphBasis before = FitMorphBasis(PicturesOf(points), 2, 1e-9, nullptr).basis;
  MorphBasis after = before;
  EXPECT_TRUE(MakeUnitWeights(after, 100));
  ExpectSamePictures(before, after);
  EXPECT_TRUE(after.weights.row(0).isZero(1e-12));
  EXPECT_LT((after.base - points[0]).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(MakeUnitWeights, WholeTurnHasACornerForItsBase) {
  const auto points = Turning(200, 358);
  const MorphBasis before = FitMorphBasis(PicturesOf(points), 2, 1e-9, nullptr).basis;
  MorphBasis after = before;
  EXPECT_FALSE(MakeUnitWeights(after, 10)) << "the first picture's cone is nearly a half-plane";
  ExpectSamePictures(before, after);
}

TEST(MakeUnitWeights, PicturesAsTargetsStayAsTheyAre) {
  const auto points = Turning(4, 90);
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(4, 3);
  weights.bottomRows(3).setIdentity();
  MorphBasis basis{points[0], {}, weights};
  for (int k = 1; k < 4; ++k) basis.targets.push_back(points[k] - points[0]);
  const MorphBasis before = basis;
  EXPECT_TRUE(MakeUnitWeights(basis, 1e9));
  EXPECT_EQ(basis.weights, weights);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(basis.targets[k], before.targets[k]);
}

}  // namespace keypose::exporting::morph_basis_test
