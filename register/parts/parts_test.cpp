#include "register/parts/parts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iterator>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "register/testing/scenes.h"

namespace keypose::registration::parts_test {

using Eigen::RowVector3d;
using Eigen::Vector3d;

Mesh Ball(double radius, const RowVector3d& centre) {
  Mesh ball = MakeIcosphere(2);
  ball.points = (radius * ball.points).rowwise() + centre;
  return ball;
}

/// A tube of length 4 with two eyeballs near its end. One eyeball has a pupil. Half of each eyeball
/// is inside the tube.
struct TubeWithEyes {
  Mesh tube = MakeCylinder(0.3, 4, 32, 80);
  Mesh left = Ball(0.1, {0.3, 0, 3.5}), right = Ball(0.1, {-0.3, 0, 3.5}),
       pupil = Ball(0.02, {0.4, 0, 3.5});
  Mesh mesh = Joined(Joined(Joined(tube, left), right), pupil);
  int first_eye = tube.vertex_count(), eye = left.vertex_count();

  /// Bends the tube by `angle` in the xz plane. The eyes do not move.
  PointsX3 Bent(double angle) const {
    PointsX3 p = mesh.points;
    const double radius = 4 / angle;
    for (int v = 0; v < tube.vertex_count(); ++v) {
      const double a = p(v, 2) / radius, r = radius - p(v, 0);
      p.row(v) << radius - r * std::cos(a), p(v, 1), r * std::sin(a);
    }
    return p;
  }
  PointsX3 Rows(const PointsX3& points, int first, int count) const {
    return points.middleRows(first, count);
  }
};

/// Largest change of a distance between two vertices of a part, over the part's size.
double Shear(const PointsX3& before, const PointsX3& after) {
  double worst = 0, scale = BoundingDiagonal(before);
  for (Eigen::Index i = 0; i < before.rows(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      worst = std::max(worst, std::abs((before.row(i) - before.row(j)).norm() -
                                       (after.row(i) - after.row(j)).norm()) /
                                  scale);
  return worst;
}

TEST(FindLooseParts, EyesSitOnTheTubeAndThePupilOnItsEye) {
  const TubeWithEyes t;
  const LooseParts parts = FindLooseParts(t.mesh);
  ASSERT_EQ(parts.parts.size(), 3u);
  EXPECT_EQ(SizeOf(parts.host_vertices), t.tube.vertex_count());
  EXPECT_EQ(parts.parts[0].parent, -1);
  EXPECT_EQ(parts.parts[1].parent, -1);
  EXPECT_EQ(parts.parts[2].parent, 0);
  EXPECT_EQ(parts.parts[0].vertices.front(), t.first_eye);
  for (const LoosePart& part : parts.parts) {
    EXPECT_NEAR(part.weights.sum(), 1, 1e-12);
    EXPECT_GT(part.weights.minCoeff(), 0);
    ASSERT_EQ(std::ssize(part.anchors), part.weights.size());
  }
  for (int v : parts.parts[0].anchors) {
    EXPECT_LT(v, t.tube.vertex_count());
    EXPECT_LT((t.mesh.points.row(v) - RowVector3d(0.3, 0, 3.5)).norm(), 0.35);
  }
  const Mesh host = HostOf(t.mesh, parts);
  EXPECT_EQ(host.faces, t.tube.faces);
  EXPECT_EQ(host.points, t.tube.points);
}

TEST(FindLooseParts, ConnectedAndSeamedMeshesHaveNone) {
  const Mesh sphere = MakeIcosphere(3);
  EXPECT_TRUE(FindLooseParts(sphere).empty());
  Mesh cut;  // every face has its own corners
  cut.points.resize(3 * sphere.face_count(), 3);
  cut.faces.resize(sphere.face_count(), 3);
  for (int f = 0; f < sphere.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      cut.points.row(3 * f + k) = sphere.points.row(sphere.faces(f, k));
      cut.faces(f, k) = 3 * f + k;
    }
  EXPECT_TRUE(FindLooseParts(cut).empty());
  const Mesh two = Joined(sphere, Ball(0.5, {3, 0, 0}));
  EXPECT_TRUE(FindLooseParts(two).empty()) << "half as large is not loose";
  EXPECT_EQ(FindLooseParts(two, {.largest_share = 0.6}).parts.size(), 1u);
}

TEST(MoveLooseParts, IsExactForRigidMotionAndChangeOfSize) {
  const TubeWithEyes t;
  const LooseParts parts = FindLooseParts(t.mesh);
  Similarity3 motion;
  motion.rotation = Eigen::AngleAxisd(2.5, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  motion.translation = Vector3d(3, -1, 2);
  motion.scale = 1.7;
  const PointsX3 truth = Transformed(motion, t.mesh.points);
  PointsX3 moved = truth;
  moved.bottomRows(moved.rows() - t.first_eye).setConstant(99);  // must not be read
  EXPECT_LT((MoveLooseParts(t.mesh, parts, moved) - truth).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((MoveLoosePartsWithHost(t.mesh, parts, truth.topRows(t.first_eye)) - truth)
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
}

TEST(MoveLooseParts, EyesFollowABendWithoutShear) {
  const TubeWithEyes t;
  const LooseParts parts = FindLooseParts(t.mesh);
  for (double angle : {0.5, 1.5, 3.0, 4.7}) {
    const PointsX3 moved = MoveLooseParts(t.mesh, parts, t.Bent(angle));
    EXPECT_EQ(moved.topRows(t.first_eye), t.Bent(angle).topRows(t.first_eye)) << "the host stays";
    const double radius = 4 / angle, a = 3.5 / radius;
    for (int i = 0; i < 2; ++i) {
      const PointsX3 before = t.Rows(t.mesh.points, t.first_eye + i * t.eye, t.eye),
                     after = t.Rows(moved, t.first_eye + i * t.eye, t.eye);
      const double size = BoundingDiagonal(after) / BoundingDiagonal(before);
      EXPECT_LT(Shear(before * (after.rowwise() - after.colwise().mean()).norm() /
                          (before.rowwise() - before.colwise().mean()).norm(),
                      after),
                1e-9);
      EXPECT_GT(size, 0.7);
      EXPECT_LT(size, 1.4);
      // The eye's centre follows the bend.
      const double r = radius - (i == 0 ? 0.3 : -0.3);
      const RowVector3d centre(radius - r * std::cos(a), 0, r * std::sin(a));
      EXPECT_LT((after.colwise().mean() - centre).norm(), 0.03) << angle;
    }
    // The pupil keeps its place on the eye.
    const PointsX3 eye = t.Rows(moved, t.first_eye, t.eye),
                   pupil = t.Rows(moved, t.first_eye + 2 * t.eye, t.eye);
    const double grown = (pupil.row(0) - pupil.row(1)).norm() /
                         (t.pupil.points.row(0) - t.pupil.points.row(1)).norm();
    EXPECT_NEAR((eye.colwise().mean() - pupil.colwise().mean()).norm() / grown, 0.1, 1e-9);
  }
}

TEST(MoveLooseParts, ACollapsedHostGivesNoNan) {
  const TubeWithEyes t;
  const LooseParts parts = FindLooseParts(t.mesh);
  EXPECT_TRUE(MoveLooseParts(t.mesh, parts, PointsX3::Zero(t.mesh.vertex_count(), 3)).allFinite());
  EXPECT_THROW(MoveLooseParts(t.mesh, parts, PointsX3::Zero(3, 3)), InputError);
  EXPECT_THROW(MoveLoosePartsWithHost(t.mesh, parts, PointsX3::Zero(3, 3)), InputError);
}

TEST(RefineLooseParts, PartsTakeTheirCounterpartsAndLandmarks) {
  const TubeWithEyes t;
  const LooseParts parts = FindLooseParts(t.mesh);
  Mesh target = t.mesh;
  const RowVector3d shift(0.02, 0.03, -0.04);
  // the left eye looks elsewhere, without its pupil
  target.points.middleRows(t.first_eye, t.eye).rowwise() += shift;
  const RefinedParts refined =
      RefineLooseParts(t.mesh, parts, t.mesh.points, target, FindLooseParts(target), {});
  EXPECT_GE(refined.by_counterpart, 2);
  EXPECT_LT((refined.points - target.points).middleRows(t.first_eye, t.eye).cwiseAbs().maxCoeff(),
            1e-9);
  EXPECT_EQ(refined.points.topRows(t.first_eye), t.mesh.points.topRows(t.first_eye));

  LandmarkGoal goal;
  goal.source.vertices.setConstant(t.first_eye + 5);
  goal.target = t.mesh.points.row(t.first_eye + 5).transpose() + Vector3d(0, 0.5, 0);
  const RefinedParts marked =
      RefineLooseParts(t.mesh, parts, t.mesh.points, t.tube, FindLooseParts(t.tube), {goal});
  EXPECT_EQ(marked.by_landmarks, 1);
  EXPECT_EQ(marked.by_counterpart, 0);
  const PointsX3 moved = marked.points - t.mesh.points;
  EXPECT_LT((moved.middleRows(t.first_eye, t.eye).rowwise() - RowVector3d(0, 0.5, 0))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
  EXPECT_LT((moved.bottomRows(t.eye).rowwise() - RowVector3d(0, 0.5, 0)).cwiseAbs().maxCoeff(),
            1e-12)
      << "the pupil follows its eye";
  EXPECT_EQ(moved.middleRows(t.first_eye + t.eye, t.eye).cwiseAbs().maxCoeff(), 0);
}

TEST(RefineLooseParts, APartTurnsAndGrowsOntoItsCounterpart) {
  TubeWithEyes t;
  auto eye = t.mesh.points.middleRows(t.first_eye, t.eye);
  const RowVector3d centre = eye.colwise().mean();
  eye = ((eye.rowwise() - centre) * Eigen::DiagonalMatrix<double, 3>(1.0, 0.7, 0.5)).rowwise() +
        centre;  // no longer round
  Mesh target = t.mesh;
  const Eigen::Matrix3d turn =
      1.08 * Eigen::AngleAxisd(0.15, Vector3d(1, 2, 2).normalized()).toRotationMatrix();
  target.points.middleRows(t.first_eye, t.eye) =
      ((eye.rowwise() - centre) * turn.transpose()).rowwise() + centre;
  const auto error = [&](const PointsX3& points) {
    return (points - target.points).middleRows(t.first_eye, t.eye).rowwise().norm().maxCoeff();
  };
  const RefinedParts refined = RefineLooseParts(t.mesh, FindLooseParts(t.mesh), t.mesh.points,
                                                target, FindLooseParts(target), {});
  EXPECT_LT(error(refined.points), 0.1 * error(t.mesh.points));
}

TEST(RefineLooseParts, SeveralLandmarksTurnAPart) {
  const TubeWithEyes t;
  const LooseParts parts = FindLooseParts(t.mesh);
  const Eigen::AngleAxisd turn(0.6, Vector3d(0, 1, 1).normalized());
  const Vector3d centre(0.3, 0, 3.5);
  std::vector<LandmarkGoal> goals;
  for (int v : {0, 3, 7, 11}) {
    LandmarkGoal goal;
    goal.source.vertices.setConstant(t.first_eye + v);
    goal.target = centre + turn * (t.mesh.points.row(t.first_eye + v).transpose() - centre);
    goals.push_back(goal);
  }
  const RefinedParts refined =
      RefineLooseParts(t.mesh, parts, t.mesh.points, t.tube, FindLooseParts(t.tube), goals);
  EXPECT_EQ(refined.by_landmarks, 1);
  double worst = 0;
  for (int v = t.first_eye; v < t.first_eye + t.eye; ++v)
    worst = std::max(worst, (refined.points.row(v).transpose() -
                             (centre + turn * (t.mesh.points.row(v).transpose() - centre)))
                                .norm());
  EXPECT_LT(worst, 0.1 * 0.06)
      << "a tenth of how far the landmarks went, for the weight of its own place";
}

}  // namespace keypose::registration::parts_test
