// Suggestions on a four-legged body with known truth.
#include "register/intrinsic/suggest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "register/testing/limbed_bodies.h"

namespace keypose::registration::suggest_test {

/// Distance at rest between each vertex and the one it is mapped to, over the diagonal.
double MeanError(const Mesh& source_rest, const Mesh& target_rest, const std::vector<int>& dense) {
  double sum = 0;
  for (std::size_t v = 0; v < dense.size(); ++v)
    sum += (source_rest.points.row(v) - target_rest.points.row(dense[v])).norm();
  return sum / (static_cast<double>(dense.size()) * BoundingDiagonal(source_rest.points));
}

Eigen::Vector3d At(const Mesh& mesh, int face, const Eigen::Vector3d& barycentric) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    p += barycentric[k] * mesh.points.row(mesh.faces(face, k)).transpose();
  return p;
}

TEST(SuggestLandmarks, FindsTheSamePlacesOfABentBodyOfOtherTessellation) {
  const Mesh source = LimbedBody(kQuadruped, 4),
             target_rest = LimbedBody(kQuadruped, 4, OtherTessellation());
  const Suggestion found = SuggestLandmarks(source, Posed(target_rest), {}, {});
  const double diagonal = BoundingDiagonal(source.points);
  // A mirror image would be wrong by half the body's width on average: 0.1 of the diagonal or more.
  EXPECT_LT(MeanError(source, target_rest, found.dense), 0.025);
  EXPECT_GT(found.orientation, 0.9);
  EXPECT_GT(found.margin, 0.05);
  ASSERT_EQ(found.pairs.size(), 12u);
  int near = 0, tips = 0;
  for (const SuggestedPair& pair : found.pairs) {
    const Eigen::Vector3d p = At(source, pair.pick.source_face, pair.pick.source_barycentric);
    near += (p - At(target_rest, pair.pick.target_face, pair.pick.target_barycentric)).norm() <
            0.05 * diagonal;
    tips += pair.origin == "tip";
    EXPECT_GE(pair.confidence, 0.4);
    EXPECT_LE(pair.confidence, 1);
  }
  EXPECT_GE(near, 11);
  EXPECT_GE(tips, 3);
  EXPECT_THAT(found.explanation, ::testing::HasSubstr("6 on the source"));
}

TEST(SuggestLandmarks, TargetTheOtherWayRoundIsNotTakenForAMirrorImage) {
  // The target is the mirror image of the body, so the true point map would turn every face over.
  // The map that is found must keep the orientation instead.
  const Mesh source = LimbedBody(kQuadruped, 4);
  Mesh mirrored = LimbedBody(kQuadruped, 4, OtherTessellation());
  mirrored.points.col(0) *= -1;
  mirrored.faces.col(1).swap(mirrored.faces.col(2));
  const Suggestion found = SuggestLandmarks(source, Posed(mirrored), {}, {});
  EXPECT_GT(found.orientation, 0.9);
  EXPECT_LT(MeanError(source, mirrored, found.dense),
            0.025);  // the body is symmetric: its mirror image is itself
}

TEST(SuggestLandmarks, OneKnownPairSettlesWhichArmOfAStarIsWhich) {
  const Mesh source = LimbedBody(kStar, 4);
  // The known pair rotates the star by a quarter turn: arm +x is the target's arm +y.
  Eigen::Index arm_x = 0, arm_y = 0;
  source.points.col(0).maxCoeff(&arm_x);
  source.points.col(1).maxCoeff(&arm_y);
  LandmarkGoal known;
  known.name = "red arm";
  known.source.vertices = Eigen::Vector3i::Constant(static_cast<int>(arm_x));
  known.target = source.points.row(arm_y).transpose();
  const Suggestion found = SuggestLandmarks(source, source, {known}, {});
  Mesh turned = source;  // where each point should land
  turned.points.col(0) = -source.points.col(1);
  turned.points.col(1) = source.points.col(0);
  EXPECT_LT(MeanError(turned, source, found.dense), 0.03);
  for (const SuggestedPair& pair : found.pairs)
    EXPECT_GT((At(source, pair.pick.source_face, pair.pick.source_barycentric) -
               source.points.row(arm_x).transpose())
                  .norm(),
              0.05)
        << pair.pick.name << " repeats the known pair";
}

TEST(SuggestLandmarks, ColoursTellApartWhatHasTheSameShape) {
  Mesh source = LimbedBody(kStar, 4), target = LimbedBody(kStar, 4, OtherTessellation());
  source.colors.resize(source.points.rows(), 3);
  target.colors.resize(target.points.rows(), 3);
  const auto paint = [](const Eigen::RowVector3d& p, double arm_x, double arm_y) {
    // from the red arm on
    const double angle = std::atan2(p.y(), p.x()) - std::atan2(arm_y, arm_x);
    return Eigen::RowVector3d(127 + 120 * std::cos(angle), 127 + 120 * std::sin(angle), 90)
        .cast<std::uint8_t>()
        .eval();
  };
  for (Eigen::Index v = 0; v < source.points.rows(); ++v) {
    source.colors.row(v) = paint(source.points.row(v), 1, 0);
    target.colors.row(v) = paint(target.points.row(v), 0, 1);
  }
  Mesh turned = source;
  turned.points.col(0) = -source.points.col(1);
  turned.points.col(1) = source.points.col(0);
  EXPECT_LT(MeanError(turned, target, SuggestLandmarks(source, target, {}, {}).dense), 0.03);
}

TEST(SuggestLandmarks, SmallPiecesAreLeftOutOfTheMap) {
  const Mesh source = LimbedBody(kQuadruped, 4);
  Mesh target = Posed(source);
  const Mesh eye = MakeIcosphere(1);
  const Eigen::Index body = target.points.rows(), faces = target.faces.rows();
  target.points.conservativeResize(body + eye.points.rows(), 3);
  target.points.bottomRows(eye.points.rows()) =
      (0.2 * eye.points).rowwise() + Eigen::RowVector3d(3, 4, 5);
  target.faces.conservativeResize(faces + eye.faces.rows(), 3);
  target.faces.bottomRows(eye.faces.rows()) = eye.faces.array() + static_cast<int>(body);
  const Suggestion found = SuggestLandmarks(source, target, {}, {});
  EXPECT_LT(*std::max_element(found.dense.begin(), found.dense.end()), body);
  const Suggestion back = SuggestLandmarks(target, source, {}, {});
  for (std::size_t v = static_cast<std::size_t>(body); v < back.dense.size(); ++v) {
    EXPECT_EQ(back.dense[v], -1);
    EXPECT_EQ(back.confidence[static_cast<Eigen::Index>(v)], 0);
  }
}

TEST(SuggestLandmarks, GivesTheSameBitsForAnyThreadCount) {
  const Mesh source = LimbedBody(kQuadruped, 3),
             target = Posed(LimbedBody(kQuadruped, 3, OtherTessellation()));
  SetThreadCount(1);
  const Suggestion one = SuggestLandmarks(source, target, {}, {});
  SetThreadCount(3);
  const Suggestion three = SuggestLandmarks(source, target, {}, {});
  SetThreadCount(0);
  EXPECT_EQ(one.dense, three.dense);
  EXPECT_EQ(one.confidence, three.confidence);
  EXPECT_EQ(one.margin, three.margin);
  ASSERT_EQ(one.pairs.size(), three.pairs.size());
  for (std::size_t k = 0; k < one.pairs.size(); ++k)
    EXPECT_EQ(one.pairs[k].pick.target_face, three.pairs[k].pick.target_face);
}

TEST(SuggestLandmarks, TinyAndFlatMeshesGiveFiniteNumbers) {
  const Mesh ball = MakeIcosphere(1), box = MakeBox(1, 2, 3);
  for (const auto& [a, b] : {std::pair(ball, box), std::pair(box, ball), std::pair(box, box)}) {
    const Suggestion found = SuggestLandmarks(a, b, {}, {});
    EXPECT_TRUE(found.confidence.allFinite());
    EXPECT_TRUE(std::isfinite(found.distortion) && std::isfinite(found.orientation) &&
                std::isfinite(found.margin));
  }
}

TEST(SuggestLandmarks, NamesWhatIsWrongWithItsInput) {
  const Mesh ball = MakeIcosphere(2);
  Mesh flat = ball;
  flat.points.setZero();
  EXPECT_THROW(SuggestLandmarks(flat, ball, {}, {}), InputError);
  EXPECT_THROW(SuggestLandmarks(ball, Mesh{}, {}, {}), InputError);
  SuggestOptions options;
  options.functions = 5;
  EXPECT_THROW(SuggestLandmarks(ball, ball, {}, options), InputError);
  LandmarkGoal stray;
  stray.name = "stray";
  stray.source.vertices = Eigen::Vector3i::Constant(99999);
  try {
    SuggestLandmarks(ball, ball, {stray}, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("'stray'"));
  }
}

}  // namespace keypose::registration::suggest_test
