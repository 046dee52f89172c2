#include "export/gltf/unit_weights.h"

#include <gtest/gtest.h>

#include "export/gltf/morph_basis.h"
#include "export/gltf/testing/turning_pictures.h"

namespace keypose::exporting::unit_weights_test {

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

}  // namespace keypose::exporting::unit_weights_test
