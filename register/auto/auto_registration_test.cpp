// Registration by the default method against known truth.
#include "register/auto/auto_registration.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "register/testing/scenes.h"
#include "register/testing/tubes.h"

namespace keypose::registration::auto_registration_test {

using Eigen::RowVector3d;
using Eigen::Vector3d;

/// A ball with three different limbs: no two places look the same, and its mirror image is another
/// shape.
Mesh Body(int levels, const Eigen::Matrix3d& tessellation = Eigen::Matrix3d::Identity()) {
  const std::pair<Vector3d, double> limbs[] = {
      {{0.1, 1, 0.5}, 0.9}, {{0.9, -0.6, 0.2}, 1.3}, {{-0.7, -0.2, -0.7}, 0.6}};
  Mesh mesh = MakeIcosphere(levels);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Vector3d direction = (tessellation * mesh.points.row(v).transpose()).normalized();
    double radius = 0.4;
    for (const auto& [toward, length] : limbs)
      radius += length * std::exp(12 * (direction.dot(toward.normalized()) - 1));
    mesh.points.row(v) = radius * direction.transpose();
  }
  return mesh;
}

TEST(RegisterAuto, MeshOntoItselfStaysInPlace) {
  for (const Mesh& mesh : {Body(3), Tube(), MakeBox(1, 2, 3)}) {
    const Eigen::VectorXd errors = Errors(RegisterAuto(mesh, mesh, {}, {}, {}).points, mesh.points);
    EXPECT_LT(errors.mean(), 1e-3);
    EXPECT_LT(errors.maxCoeff(), 2e-3);
  }
}

TEST(RegisterAuto, FindsAnyTurnAndSizeWithoutLandmarks) {
  // The last target has other vertices. Its facets differ from the source by 0.007 where limbs are
  // thin.
  const Mesh other =
      Body(3, Eigen::AngleAxisd(0.4, Vector3d(3, 1, 2).normalized()).toRotationMatrix());
  const Eigen::AngleAxisd turns[] = {{M_PI, Vector3d::UnitX()},
                                     {M_PI, Vector3d(1, 2, -1).normalized()},
                                     {2.2, Vector3d(-1, 0.3, 1).normalized()},
                                     {1.3, Vector3d(0.2, 1, 1).normalized()}};
  const double scales[] = {0.01, 100, 1, 1};
  for (int k = 0; k < 4; ++k) {
    Similarity3 truth;
    truth.rotation = turns[k].toRotationMatrix();
    truth.scale = scales[k];
    truth.translation = truth.scale * Vector3d(7, -20, 3);
    const Mesh source = Body(k < 3 ? 2 : 3), target = k < 3 ? source : other;
    const AutoResult result =
        RegisterAuto(source, WithPoints(target, Transformed(truth, target.points)), {}, {}, {});
    const PointsX3 expected = Transformed(truth, source.points);
    EXPECT_LT(Errors(result.points, expected).mean(), k < 3 ? 5e-4 : 0.01) << "turn " << k;
    EXPECT_NEAR(result.scale / truth.scale, 1, 0.02) << "turn " << k;
    EXPECT_EQ(Inverted(source.faces, result.points, expected), 0) << "turn " << k;
  }
}

class BentTube : public ::testing::TestWithParam<int> {};

TEST_P(BentTube, IsFollowedWithLandmarks) {
  const double angle = GetParam() * M_PI / 180;
  const Mesh source = Tube(), rest = OtherTube();
  const PointsX3 truth = Bent(source.points, kLength, angle);
  const AutoResult result =
      RegisterAuto(source, WithPoints(rest, Bent(rest.points, kLength, angle)),
                   Every(kGoalStride, truth), {}, {});
  EXPECT_LT(Errors(result.points, truth).mean(), 0.003);
  EXPECT_EQ(Inverted(source.faces, result.points, truth), 0);
  EXPECT_EQ(result.alignment.method, "procrustes");
  EXPECT_EQ(result.points.rows(), source.points.rows());
  ASSERT_LT(static_cast<std::size_t>(result.chosen), result.starts.size());
}

INSTANTIATE_TEST_SUITE_P(Degrees, BentTube, ::testing::Values(40, 90, 140, 180, 230, 270));

// A landmark 4 % of the diagonal off the surface contradicts it.
TEST(RegisterAuto, HeavierLandmarksAreMetMoreClosely) {
  const Mesh mesh = Body(3);
  std::vector<LandmarkGoal> goals = Every(kGoalStride, mesh.points);
  goals[0].target *= 1 + 0.04 * BoundingDiagonal(mesh.points) / goals[0].target.norm();
  const auto left = [&](double start, double end) {
    AutoOptions options;
    options.landmark_weight = start;
    options.landmark_weight_end = end;
    const PointsX3 found = RegisterAuto(mesh, mesh, goals, {}, options).points;
    return (PositionOf(goals[0].source, found) - goals[0].target).norm();
  };
  EXPECT_LT(left(1000, 1000), 0.5 * left(50, 0.05));
  EXPECT_NE(left(1000, 5), left(1, 5));
}

TEST(RegisterAuto, PoorFitDecidesHowManyStartsAreTried) {
  const Mesh source = Tube(), rest = OtherTube();
  const Mesh target = WithPoints(rest, Bent(rest.points, kLength, 2.5));
  const auto starts = [&](double poor_fit) {
    AutoOptions options;
    options.good_fit = std::min(options.good_fit, poor_fit);
    options.poor_fit = poor_fit;
    return RegisterAuto(source, target, {}, {}, options).starts.size();
  };
  EXPECT_LT(starts(1), starts(1e-7));
}

TEST(RegisterAuto, SmootherMapsStretchMoreEvenly) {
  const Mesh source = Tube();
  const PointsX3 truth = Bent(source.points, kLength, 1.5);
  const auto points = [&](double smoothing) {
    AutoOptions options;
    options.smoothing = smoothing;
    return RegisterAuto(source, WithPoints(OtherTube(), Bent(OtherTube().points, kLength, 1.5)),
                        Every(kGoalStride, truth), {}, options)
        .points;
  };
  EXPECT_NE(points(0), points(0.1));
}

/// Bends a body about one axis by an angle that grows along another.
PointsX3 Twisted(const PointsX3& points) {
  PointsX3 twisted = points;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    twisted.row(v) = (Eigen::AngleAxisd(0.6 * points(v, 1), Vector3d(1, 0, 0.4).normalized()) *
                      points.row(v).transpose())
                         .transpose();
  return twisted;
}

TEST(RegisterAuto, MovesWithItsInputs) {
  const Mesh source = Body(3),
             rest =
                 Body(3, Eigen::AngleAxisd(0.4, Vector3d(3, 1, 2).normalized()).toRotationMatrix());
  const Mesh target = WithPoints(rest, Twisted(rest.points));
  const PointsX3 truth = Twisted(source.points);
  const PointsX3 before = RegisterAuto(source, target, Every(60, truth), {}, {}).points;
  EXPECT_LT(Errors(before, truth).mean(), 0.01);
  const auto moved = [&](const Similarity3& of_source, const Similarity3& of_target) {
    std::vector<LandmarkGoal> goals = Every(60, Transformed(of_target, truth));
    return RegisterAuto(WithPoints(source, Transformed(of_source, source.points)),
                        WithPoints(target, Transformed(of_target, target.points)), goals, {}, {})
        .points;
  };
  Similarity3 of_source, of_target;
  of_source.scale = 30;
  of_source.translation << 5, 6, -7;
  of_source.rotation << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  of_target.scale = 0.2;
  of_target.translation << -1, 3, 2;
  of_target.rotation << 0, 0, -1, -1, 0, 0, 0, 1,
      0;  // keeps the bounding diagonal, by which lengths are judged
  EXPECT_LT(Errors(moved(of_source, of_target), Transformed(of_target, before)).maxCoeff(), 1e-6);
  of_target.rotation = Eigen::AngleAxisd(2.3, Vector3d(1, -1, 2).normalized()).toRotationMatrix();
  EXPECT_LT(Errors(moved(of_source, of_target), Transformed(of_target, before)).maxCoeff(), 0.01);
}

/// How far the motion of the vertices is from one similarity transform.
double Deformation(const PointsX3& before, const PointsX3& after,
                   const std::vector<int>& vertices) {
  const PointsX3 a = before(vertices, Eigen::all), b = after(vertices, Eigen::all);
  return (Transformed(FitSimilarity(a, b), a) - b).norm();
}

TEST(RegisterAuto, StiffPartsKeepTheirShapeBetter) {
  const Mesh tube = Tube();
  Mesh target = OtherTube();
  target.points = Bent(target.points, kLength, 0.8);
  const PointsX3 truth = Bent(tube.points, kLength, 0.8);
  Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(tube.vertex_count());
  std::vector<int> low;
  for (int v = 0; v < tube.vertex_count(); ++v)
    if (tube.points(v, 2) < 1) {
      stiffness[v] = 300;
      low.push_back(v);
    }
  const PointsX3 plain = RegisterAuto(tube, target, Every(kGoalStride, truth), {}, {}).points;
  const PointsX3 held = RegisterAuto(tube, target, Every(kGoalStride, truth), stiffness, {}).points;
  EXPECT_LT(Deformation(tube.points, held, low), 0.9 * Deformation(tube.points, plain, low));
}

TEST(RegisterAuto, ALooseBallFollowsWithoutChangingShape) {
  const Mesh tube = Tube();
  Mesh ball = MakeIcosphere(2);
  const double size = 0.05;
  ball.points = (size * ball.points).rowwise() + RowVector3d(kRadius, 0, 1.5);
  const Mesh source = Joined(tube, ball);
  const double angle = 2;
  const PointsX3 truth = Bent(tube.points, kLength, angle);
  Mesh target = OtherTube();
  target.points = Bent(target.points, kLength, angle);
  const AutoResult result = RegisterAuto(source, target, Every(kGoalStride, truth), {}, {});
  EXPECT_EQ(result.loose_parts, 1);
  EXPECT_LT(Errors(result.points.topRows(tube.vertex_count()), truth).mean(), 0.003);
  // A rigid motion: the ball's centre follows the bend, and the ball is rotated by the bend's angle
  // there.
  const PointsX3 found = result.points.bottomRows(ball.vertex_count());
  PointsX3 centre(1, 3);
  centre << kRadius, 0, 1.5;
  EXPECT_LT(
      (found.colwise().mean() - Bent(centre, kLength, angle)).norm() / BoundingDiagonal(truth),
      0.003);
  const Similarity3 motion = FitSimilarity(ball.points, found);
  EXPECT_LT((Transformed(motion, ball.points) - found).rowwise().norm().maxCoeff(), 0.01 * size);
  EXPECT_NEAR(motion.scale, 1, 0.1);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(angle * 1.5 / kLength, Vector3d::UnitY()).toRotationMatrix();
  EXPECT_LT(Eigen::AngleAxisd(motion.rotation.transpose() * turn).angle(), 0.05);
  for (int v = tube.vertex_count(); v < source.vertex_count(); ++v)
    EXPECT_LT((result.transforms[v] - motion.scale * motion.rotation).norm(), 1e-6);
}

TEST(RegisterAuto, TransformsCarryEachNeighbourhood) {
  const Mesh source = Tube(), rest = OtherTube();
  const double angle = 2.5;
  const PointsX3 truth = Bent(source.points, kLength, angle);
  Similarity3 grow;
  grow.scale = 3;
  grow.rotation = Eigen::AngleAxisd(1, Vector3d::UnitZ()).toRotationMatrix();
  const Mesh target = WithPoints(rest, Transformed(grow, Bent(rest.points, kLength, angle)));
  const AutoResult result =
      RegisterAuto(source, target, Every(kGoalStride, Transformed(grow, truth)), {}, {});
  ASSERT_EQ(result.transforms.size(), static_cast<std::size_t>(source.vertex_count()));
  double misfit = 0, length = 0;
  for (int v = 0; v < source.vertex_count(); ++v) {
    ASSERT_TRUE(result.transforms[v].allFinite());
    EXPECT_NEAR(result.transforms[v].determinant(), 27, 9);
  }
  for (const auto& [i, j] : UndirectedEdges(source.faces)) {
    const Vector3d edge = (result.points.row(j) - result.points.row(i)).transpose();
    misfit +=
        (result.transforms[i] * (source.points.row(j) - source.points.row(i)).transpose() - edge)
            .norm();
    length += edge.norm();
  }
  EXPECT_LT(misfit / length, 0.1);
}

/// A tube bent by 46 degrees, with few landmarks, so that other starts are tried too.
AutoResult BentByFewLandmarks(const AutoOptions& options) {
  constexpr double kAngle = 0.8;
  const Mesh source = Tube(), target = WithPoints(source, Bent(source.points, kLength, kAngle));
  const std::vector<LandmarkGoal> all = Every(kGoalStride, target.points);
  return RegisterAuto(source, target, {all.front(), all[all.size() / 2], all.back()}, {}, options);
}

TEST(RegisterAuto, AStartThatLosesLeavesNothingButItsTrial) {
  AutoOptions one_start, more_starts;
  one_start.suggest = one_start.skeleton = false;
  const AutoResult alone = BentByFewLandmarks(one_start), among = BentByFewLandmarks(more_starts);
  ASSERT_EQ(alone.starts.size(), 1u);
  ASSERT_GT(among.starts.size(), 1u);
  ASSERT_EQ(among.chosen, 0);
  // Each start scales the rest shape by a factor from the size before, and these factors round.
  constexpr double kRounding = 1e-12;
  EXPECT_LT((among.points - alone.points).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_NEAR(among.gap, alone.gap, kRounding);
  EXPECT_NEAR(among.scale, alone.scale, kRounding);
  EXPECT_EQ(among.softened, alone.softened);
  EXPECT_EQ(among.starts[0].gap, alone.starts[0].gap);
  EXPECT_EQ(among.starts[0].score, alone.starts[0].score);
}

TEST(RegisterAuto, SameBitsAtOneAndTwoThreads) {
  const Mesh source = Tube(), body = Body(2);
  Mesh target = OtherTube(),
       other = Body(2, Eigen::AngleAxisd(0.4, Vector3d::UnitX()).toRotationMatrix());
  target.points = Bent(target.points, kLength, 1.2);
  other.points = Twisted(other.points);
  std::vector<AutoResult> with, without;
  for (const int threads : {1, 2}) {
    SetThreadCount(threads);
    with.push_back(RegisterAuto(source, target,
                                Every(kGoalStride, Bent(source.points, kLength, 1.2)), {}, {}));
    without.push_back(RegisterAuto(body, other, {}, {}, {}));
  }
  SetThreadCount(0);
  EXPECT_EQ(with[0].points, with[1].points);
  EXPECT_EQ(with[0].transforms, with[1].transforms);
  EXPECT_EQ(without[0].points, without[1].points);
}

TEST(RegisterAuto, CancelsWithinTheRun) {
  class Stop : public Progress {
   public:
    void Update(double fraction, std::string_view) override { last = fraction; }
    bool cancelled() const override { return last > 0.3; }
    double last = 0;
  } stop;
  EXPECT_THROW(RegisterAuto(Tube(), OtherTube(), {}, {}, {}, &stop), Cancelled);
}

}  // namespace keypose::registration::auto_registration_test
