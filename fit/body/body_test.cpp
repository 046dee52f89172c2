#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "core/io/meshes/bvh_io.h"
#include "core/surfaces/geometry.h"
#include "core/values/angles.h"
#include "core/values/motion_clip.h"
#include "fit/body/body_clip.h"
#include "fit/body/body_pose.h"
#include "fit/body/body_surface.h"

namespace keypose::fit::body_test {

// A pose in which no number is zero, within the limits, the same on every machine.
BodyPose SomePose(int seed) {
  BodyPose pose;
  for (int i = 0; i < kDofs; ++i) {
    const double wave = std::sin(12.9898 * (i + 1) + 78.233 * (seed + 1));
    const DofModel& dof = Dofs()[i];
    pose.q[i] = dof.low == dof.high ? 0.7 * wave
                                    : (dof.low + dof.high) / 2 + 0.45 * wave * (dof.high - dof.low);
  }
  pose.root_chart = Eigen::Quaterniond(
      Eigen::AngleAxisd(1.1 * seed, Eigen::Vector3d(0.2, 0.3, 0.9).normalized()));
  return pose;
}

TEST(BodyTemplate, HasSixteenSegmentsAndItsDofsAreAllUsedOnce) {
  std::array<int, kDofs> used{};
  for (int i = 0; i < 3; ++i) ++used[i];
  for (const JointModel& joint : Joints())
    for (int k = 0; k < (joint.ball ? 3 : static_cast<int>(joint.hinges.size())); ++k)
      ++used[joint.first_dof + k];
  for (int i = 0; i < kDofs; ++i) EXPECT_EQ(used[i], i >= 6 && i < 9 ? 2 : 1) << Dofs()[i].name;
  for (const DofModel& dof : Dofs()) EXPECT_FALSE(dof.name.empty());
  EXPECT_GE(kDofs, 35);
  EXPECT_LE(kDofs, 38);
}

TEST(BodySurface, EverySegmentIsAClosedManifold) {
  const BodyShape shape = AverageShape();
  const LocalSurface surface = SurfaceOf(shape);
  for (int s = 0; s < kSegments; ++s) {
    const ClosedReport report = CheckClosed({surface.points[s], SegmentFaces(), {}, {}, {}, {}});
    EXPECT_TRUE(report.closed()) << Segments()[s].name;
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.euler, 2);
  }
  const PosedBody body = Posed({}, shape);
  const PointsX3 points = BodyPoints(surface, body);
  EXPECT_EQ(CheckClosed({points, BodyFaces(), {}, {}, {}, {}}).components, kSegments);
  // A person of 1.75 m, 1.7 m wide with its arms out, and 0.3 m deep at the feet.
  const Eigen::RowVector3d size = points.colwise().maxCoeff() - points.colwise().minCoeff();
  EXPECT_NEAR(size.z(), 1.75, 0.03);
  EXPECT_NEAR(size.x(), 1.78, 0.1);
  EXPECT_NEAR(shape.height(), 1.75, 0.03);
}

TEST(BodySurface, LeftAndRightAreMirrored) {
  const PointsX3 points = BodyPoints(SurfaceOf(AverageShape()), Posed({}, AverageShape()));
  for (const auto& [left, right] : {std::pair{4, 7}, {6, 9}, {10, 13}, {12, 15}}) {
    const auto rows = [&](int s) {
      return points.middleRows(s * kSegmentVertices, kSegmentVertices);
    };
    EXPECT_NEAR(rows(left).col(0).maxCoeff(), -rows(right).col(0).minCoeff(), 1e-12);
    EXPECT_NEAR(rows(left).col(2).mean(), rows(right).col(2).mean(), 1e-12);
  }
}

TEST(LeftJacobian, MatchesCentralDifferencesAtSmallAndLargeAngles) {
  for (const double size : {0.0, 1e-6, 1e-4, 1e-3, 1e-2, 0.5, 2.0, 3.1}) {
    const Eigen::Vector3d w = size * Eigen::Vector3d(0.6, -0.48, 0.64);
    const Eigen::Matrix3d j = LeftJacobian(w);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
      const Eigen::Matrix3d change =
          (RotationOf(w + step) - RotationOf(w - step)) / 2e-6 * RotationOf(w).transpose();
      const Eigen::Vector3d turn(change(2, 1), change(0, 2), change(1, 0));
      // 1e-9: rounding of a difference quotient of numbers near one
      EXPECT_LT((j.col(k) - turn).norm(), 1e-9) << size << " " << k;
    }
  }
}

TEST(PosedBody, PoseDerivativesMatchCentralDifferences) {
  const BodyShape shape = AverageShape();
  const Eigen::Vector3d local(0.05, -0.03, 0.08), w(0.3, -0.8, 0.5);
  for (int seed = 0; seed < 4; ++seed) {
    const BodyPose pose = SomePose(seed);
    const PosedBody body = Posed(pose, shape);
    for (int joint = 0; joint < kJoints; ++joint) {
      DofVector row = DofVector::Zero();
      body.AddPoseRow(joint, body.ToWorld(joint, local), w, row.data());
      for (int i = 0; i < kDofs; ++i) {
        BodyPose plus = pose, minus = pose;
        plus.q[i] += 1e-6, minus.q[i] -= 1e-6;
        const double slope = w.dot(Posed(plus, shape).ToWorld(joint, local) -
                                   Posed(minus, shape).ToWorld(joint, local)) /
                             2e-6;
        // 2e-9: rounding of a difference quotient of lengths near one metre
        EXPECT_NEAR(row[i], slope, 2e-9) << Joints()[joint].name << " " << Dofs()[i].name;
      }
    }
  }
}

TEST(PosedBody, ShapeDerivativesMatchCentralDifferences) {
  const BodyPose pose = SomePose(2);
  const BodyShape shape = AverageShape();
  const Eigen::Vector3d w(0.3, -0.8, 0.5);
  const auto place = [&](const BodyShape& s, int segment, int vertex) {
    return Posed(pose, s).ToWorld(Segments()[segment].joint,
                                  SurfaceOf(s).points[segment].row(vertex).transpose());
  };
  for (const auto& [segment, vertex] :
       {std::pair{2, 40}, {5, 111}, {12, 200}, {15, kSegmentVertices - 1}}) {
    const int joint = Segments()[segment].joint;
    const PosedBody body = Posed(pose, shape);
    Eigen::Matrix<double, kLengths, 1> lengths = Eigen::Matrix<double, kLengths, 1>::Zero();
    Eigen::Matrix<double, kStations * kHarmonics, 1> radii;
    radii.setZero();
    body.AddLengthRow(joint, w, lengths.data());
    AddSurfaceRow(segment, vertex, body.rotation[joint].transpose() * w, 1, lengths.data(),
                  radii.data());
    for (int l = 0; l < kLengths; ++l) {
      BodyShape plus = shape, minus = shape;
      plus.lengths[l] += 1e-6, minus.lengths[l] -= 1e-6;
      EXPECT_NEAR(lengths[l],
                  w.dot(place(plus, segment, vertex) - place(minus, segment, vertex)) / 2e-6, 2e-9);
    }
    for (int r = 0; r < kStations * kHarmonics; ++r) {
      BodyShape plus = shape, minus = shape;
      plus.radii[segment](r / kHarmonics, r % kHarmonics) += 1e-6;
      minus.radii[segment](r / kHarmonics, r % kHarmonics) -= 1e-6;
      EXPECT_NEAR(radii[r],
                  w.dot(place(plus, segment, vertex) - place(minus, segment, vertex)) / 2e-6, 2e-9);
    }
  }
}

TEST(PosedBody, ALimbThatIsPosedAnewIsWhereTheWholeBodyHasIt) {
  const BodyShape shape = AverageShape();
  const BodyPose before = SomePose(1);
  BodyPose after = before;
  after.q.segment<6>(Joints()[kShoulderR].first_dof) << 0.4, -0.3, 0.9, 1.1, 0.2, -0.1;
  PosedBody body = Posed(before, shape);
  Repose(after, shape, kShoulderR, kWristR, &body);
  const PosedBody whole = Posed(after, shape);
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_EQ(body.rotation[j], whole.rotation[j]);
    EXPECT_EQ(body.position[j], whole.position[j]);
    ASSERT_EQ(body.turns[j].size(), whole.turns[j].size());
    for (std::size_t k = 0; k < body.turns[j].size(); ++k)
      EXPECT_EQ(body.turns[j][k].axis, whole.turns[j][k].axis);
  }
}

TEST(MarkingPose, StandsUprightWithItsHandsBesideTheHipsAndItsFeetApart) {
  const BodyShape shape = AverageShape(1.7);
  const PosedBody body = Posed(MarkingPose(), shape);
  EXPECT_GT(body.position[kNeck].z(), body.position[kPelvis].z() + 0.3);
  for (const auto& [shoulder, wrist, ankle, side] :
       {std::tuple{kShoulderL, kWristL, kAnkleL, 1.0}, {kShoulderR, kWristR, kAnkleR, -1.0}}) {
    const Eigen::Vector3d arm = body.position[wrist] - body.position[shoulder];
    EXPECT_NEAR(std::atan2(-arm.z(), side * arm.x()), 0.7, 0.01);
    EXPECT_GT(side * body.position[ankle].x(), 0.2);
  }
}

TEST(BodyPose, RechartedPoseIsTheSame) {
  const BodyPose pose = SomePose(3);
  const PosedBody a = Posed(pose, AverageShape()), b = Posed(pose.Recharted(), AverageShape());
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_LT((a.position[j] - b.position[j]).norm(), 1e-12);
    EXPECT_LT((a.rotation[j] - b.rotation[j]).norm(), 1e-12);
  }
}

TEST(ClipOf, BvhHasTheJointsWhereTheTemplateHasThem) {
  const BodyShape shape = AverageShape();
  const std::vector<BodyPose> poses{SomePose(0), SomePose(1), SomePose(2)};
  const Eigen::Quaterniond up(Eigen::AngleAxisd(-kPi / 2, Eigen::Vector3d::UnitX()));
  const MotionClip clip = ParseBvh(BvhText(ClipOf(poses, shape, 0.04, up)), "clip");
  for (int f = 0; f < 3; ++f) {
    const std::vector<Rigid3> frames = JointFrames(clip, f);
    const PosedBody body = Posed(poses[f], shape);
    for (int j = 0; j < kJoints; ++j) {
      const int place = clip.Find(Joints()[j].name);
      ASSERT_GE(place, 0);
      // six decimals of a degree and of a metre, through a chain of six joints
      EXPECT_LT((frames[place].translation - up * body.position[j]).norm(), 1e-5)
          << Joints()[j].name;
    }
  }
}

}  // namespace keypose::fit::body_test
