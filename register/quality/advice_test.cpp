#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "register/quality/registration_quality.h"
#include "register/testing/scenes.h"

namespace keypose::registration::advice_test {

/// A tube whose far half bends sideways, and a registration that left that half where it was.
struct LeftBehind {
  Mesh source, target;
  explicit LeftBehind(int around = 20, int along = 80)
      : source(MakeCylinder(0.15, 4, around, along)), target(source) {
    for (int i = 0; i < target.vertex_count(); ++i)
      target.points(i, 0) += 0.4 * std::pow(std::max(0.0, target.points(i, 2) - 2), 2);
  }
  LandmarkGoal At(double z) const {
    int best = 0;
    (source.points.rowwise() - Eigen::RowVector3d(0.15, 0, z)).rowwise().norm().minCoeff(&best);
    LandmarkGoal goal;
    goal.source.vertices.setConstant(best);
    goal.target = target.points.row(best);
    return goal;
  }
};

TEST(AdviseLandmarks, PointsAtTheLimbThatStayedBehind) {
  const LeftBehind pair;
  const std::vector<LandmarkAdvice> advice =
      AdviseLandmarks(pair.source, pair.source.points, pair.target, {pair.At(0), pair.At(1.5)});
  ASSERT_FALSE(advice.empty());
  EXPECT_GT(advice[0].position.z(), 3);
  EXPECT_GT(advice[0].misfit, 0.02);
  EXPECT_GT(advice[0].landmark_distance, 0.2);
  EXPECT_NE(advice[0].reason.find("end of a limb"), std::string::npos) << advice[0].reason;
  for (std::size_t i = 1; i < advice.size(); ++i) {
    EXPECT_LE(advice[i].score, advice[i - 1].score);
    EXPECT_GT((advice[i].position - advice[0].position).norm(),
              0.05 * BoundingDiagonal(pair.source.points));
  }
}

TEST(AdviseLandmarks, ManyFacesAreSampledToTheSameEnd) {
  const LeftBehind few, many(300, 500);
  ASSERT_GT(many.source.face_count(), 250000);
  const std::vector<LandmarkAdvice> all =
      AdviseLandmarks(few.source, few.source.points, few.target, {few.At(0), few.At(1.5)}, 1);
  const std::vector<LandmarkAdvice> some =
      AdviseLandmarks(many.source, many.source.points, many.target, {many.At(0), many.At(1.5)}, 1);
  ASSERT_EQ(all.size(), 1);
  ASSERT_EQ(some.size(), 1);
  EXPECT_GT(some[0].position.z(), 3);
  EXPECT_NEAR(some[0].misfit, all[0].misfit, 0.15 * all[0].misfit);
  EXPECT_NEAR(some[0].stretch, all[0].stretch, 0.05);
}

TEST(AdviseLandmarks, AsksForNothingWhereAllIsWell) {
  const LeftBehind pair;
  EXPECT_TRUE(AdviseLandmarks(pair.source, pair.source.points, pair.source, {}).empty());
  EXPECT_TRUE(AdviseLandmarks(pair.source, pair.source.points, pair.target, {}, 0).empty());
}

TEST(AdviseLandmarks, LargeCoordinatesGiveFiniteNumbersAndTooLargeOnesAreRefused) {
  LeftBehind pair;
  const auto advise_at = [&](double size) {
    Mesh source = pair.source, target = pair.target;
    source.points *= size;
    target.points *= size;
    PointsX3 stretched = source.points;
    stretched.col(2) *= 3;
    return AdviseLandmarks(source, stretched, target, {});
  };
  EXPECT_THROW(advise_at(1e25), InputError) << "closest points are searched in single precision";
  const std::vector<LandmarkAdvice> advice = advise_at(1e10);
  ASSERT_FALSE(advice.empty());
  for (const LandmarkAdvice& a : advice)
    EXPECT_TRUE(std::isfinite(a.misfit) && std::isfinite(a.score)) << a.reason;
}

TEST(AdviseLandmarks, LeavesSmallLoosePartsAlone) {
  LeftBehind pair;
  const Mesh ball = MakeIcosphere(2);
  Mesh both;
  both.points.resize(pair.source.vertex_count() + ball.vertex_count(), 3);
  both.points << pair.source.points, (0.05 * ball.points).rowwise() + Eigen::RowVector3d(3, 3, 3);
  both.faces.resize(pair.source.face_count() + ball.face_count(), 3);
  both.faces << pair.source.faces, (ball.faces.array() + pair.source.vertex_count()).matrix();
  for (const LandmarkAdvice& a : AdviseLandmarks(both, both.points, pair.target, {}))
    EXPECT_LT(a.vertex, pair.source.vertex_count());
}

}  // namespace keypose::registration::advice_test
