#include "motion/body/body_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "motion/body/body_surface.h"
#include "motion/body/testing/some_pose.h"

namespace keypose::motion::body_pose_test {

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

}  // namespace keypose::motion::body_pose_test
