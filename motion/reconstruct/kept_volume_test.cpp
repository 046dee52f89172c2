#include "motion/reconstruct/kept_volume.h"

#include <gtest/gtest.h>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::motion::kept_volume_test {

/// A ball, and a smaller one beside it.
Mesh TwoBalls() {
  Mesh mesh = MakeIcosphere(3);
  const Mesh small = MakeIcosphere(2);
  const int before = mesh.vertex_count(), faces = mesh.face_count();
  mesh.points.conservativeResize(before + small.vertex_count(), 3);
  mesh.points.bottomRows(small.vertex_count()) =
      (0.3 * small.points).rowwise() + Eigen::RowVector3d(2, 0, 0);
  mesh.faces.conservativeResize(faces + small.face_count(), 3);
  mesh.faces.bottomRows(small.face_count()) = small.faces.array() + before;
  return mesh;
}

TEST(KeptVolume, MeasuresVolumesAndTheirDerivatives) {
  const Mesh balls = TwoBalls();
  const int first_faces = MakeIcosphere(3).face_count();
  const PoissonSystem system({balls.points}, balls.faces);
  const KeptVolume kept(system, balls.points);
  PointsX3 pose = balls.points;
  pose.col(2) += 0.2 * pose.col(0).cwiseProduct(pose.col(0));
  const double first = SignedVolume(pose, balls.faces.topRows(first_faces)),
               second =
                   SignedVolume(pose, balls.faces.bottomRows(balls.face_count() - first_faces));
  const std::vector<double> volumes = kept.Volumes(pose);
  EXPECT_NEAR(volumes[0], first, 1e-12);
  EXPECT_NEAR(volumes[1], second, 1e-12);
  const Eigen::MatrixXd pull = pose.col(0).array().sin().matrix();
  KeptVolume::State state;
  kept.Measure(pose, pull, state);
  EXPECT_NEAR(state.volume[0], first, 1e-12);
  EXPECT_NEAR(state.volume[1], second, 1e-12);
  // Symmetric differences: the rest is of the third order.
  const double step = 1e-4;
  const auto slope = [&](int part, const PointsX3& direction) {
    return (kept.Volumes(pose + step * direction)[part] -
            kept.Volumes(pose - step * direction)[part]) /
           (2 * step);
  };
  for (int part = 0; part < 2; ++part) {
    EXPECT_NEAR(state.slope[part], slope(part, state.field), 1e-7);
    for (int c = 0; c < 3; ++c) {
      PointsX3 direction = PointsX3::Zero(pose.rows(), 3);
      direction.col(c) = pull.col(0);
      EXPECT_NEAR(state.gains(part, c), slope(part, direction), 1e-7);
    }
  }
}

}  // namespace keypose::motion::kept_volume_test
