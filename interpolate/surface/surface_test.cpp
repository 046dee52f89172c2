#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "interpolate/surface/arap.h"
#include "interpolate/surface/paper_arap.h"
#include "interpolate/surface/testing/bent_sheets.h"

namespace keypose::interpolation::surface_test {

Eigen::Matrix3d Turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

TEST(Arap, RigidMotionGivesRigidFrames) {
  const Mesh mesh = MakeCylinder(0.3, 2, 12, 10);
  Similarity3 motion;
  motion.rotation = Turn(2.5, {1, 2, -1});
  motion.translation << 3, 1, -2;
  const ArapInterpolator arap(mesh.points, Transformed(motion, mesh.points), mesh.faces);
  for (double t : {0.1, 0.37, 0.5, 0.9}) {
    const PointsX3 frame = arap.At(t);
    for (const auto& [i, j] : UndirectedEdges(mesh.faces))
      EXPECT_NEAR((frame.row(i) - frame.row(j)).norm(),
                  (mesh.points.row(i) - mesh.points.row(j)).norm(), 1e-10);
  }
}

TEST(Arap, UniformGrowthIsGeometricWithLogAndStraightWithLinearStretch) {
  const Mesh mesh = MakeIcosphere(2);
  const PointsX3 grown = 3 * mesh.points;
  EXPECT_LT(Gap(ArapInterpolator(mesh.points, grown, mesh.faces).At(0.25),
                std::pow(3, 0.25) * mesh.points),
            1e-12);
  EXPECT_LT(Gap(ArapInterpolator(mesh.points, grown, mesh.faces, PaperOptions()).At(0.25),
                1.5 * mesh.points),
            1e-12);
  EXPECT_LT(Gap(PaperInterpolator(mesh.points, grown, mesh.faces).At(0.25), 1.5 * mesh.points),
            1e-10);
}

TEST(Arap, MiddleOfATurnBy179DegreesIs89AndAHalf) {
  const Mesh mesh = MakeBox(1, 2, 3);
  const PointsX3 u = mesh.points * Turn(179 * kPi / 180, Eigen::Vector3d::UnitZ()).transpose();
  const ArapInterpolator arap(mesh.points, u, mesh.faces);
  const PointsX3 frame = arap.At(0.5), centred = frame.rowwise() - frame.colwise().mean();
  const PointsX3 start = mesh.points.rowwise() - mesh.points.colwise().mean();
  EXPECT_LT(Gap(centred, start * Turn(89.5 * kPi / 180, Eigen::Vector3d::UnitZ()).transpose()),
            1e-10);
}

TEST(Arap, EndsAreTheKeysAndIdenticalKeysStayPut) {
  const Keys keys;
  const ArapInterpolator arap(keys.mesh.points, keys.u, keys.mesh.faces);
  EXPECT_LT(Gap(arap.At(0), keys.mesh.points), 1e-11);
  EXPECT_LT(Gap(arap.At(1), keys.u), 1e-11);
  const ArapInterpolator still(keys.u, keys.u, keys.mesh.faces);
  EXPECT_LT(Gap(still.At(0.4), keys.u), 1e-11);
}

TEST(Arap, SwappingTheKeysReversesTime) {
  const Keys keys;
  const ArapInterpolator there(keys.mesh.points, keys.u, keys.mesh.faces),
      back(keys.u, keys.mesh.points, keys.mesh.faces);
  for (double t : {0.2, 0.5, 0.7}) EXPECT_LT(Gap(there.At(t), back.At(1 - t)), 1e-12);
}

TEST(Arap, MiddleOfABendIsTheArcOfHalfTheAngle) {
  Mesh coarse = MakeCylinder(0.12, 2, 16, 40), fine = MakeCylinder(0.12, 2, 32, 80);
  const auto error = [](const Mesh& mesh) {
    const ArapInterpolator arap(mesh.points, Bent(mesh.points, 2, 1.6), mesh.faces);
    const PointsX3 truth = Bent(mesh.points, 2, 0.8), frame = arap.At(0.5);
    const Similarity3 fit = FitSimilarity(frame, truth, {}, false);
    return (Transformed(fit, frame) - truth).rowwise().norm().mean() / Diagonal(truth);
  };
  EXPECT_LT(error(fine), 2e-3);
  EXPECT_LT(error(fine), error(coarse) + 1e-6);
}

TEST(Arap, PermutedVerticesGiveThePermutedResult) {
  const Keys keys;
  const int n = keys.mesh.vertex_count();
  PointsX3 v(n, 3), u(n, 3);
  FacesX3 faces = keys.mesh.faces;
  const auto to = [&](int i) { return (i * 11 + 3) % n; };
  ASSERT_NE(n % 11, 0);
  for (int i = 0; i < n; ++i) v.row(to(i)) = keys.mesh.points.row(i), u.row(to(i)) = keys.u.row(i);
  for (Eigen::Index k = 0; k < faces.size(); ++k) faces.data()[k] = to(faces.data()[k]);
  const PointsX3 a = ArapInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).At(0.3),
                 b = ArapInterpolator(v, u, faces).At(0.3);
  for (int i = 0; i < n; ++i) EXPECT_LT((a.row(i) - b.row(to(i))).norm(), 1e-10);
}

Mesh TwoSpheres() {
  Mesh mesh = MakeIcosphere(1);
  const int n = mesh.vertex_count(), m = mesh.face_count();
  mesh.points.conservativeResize(2 * n, 3);
  mesh.points.bottomRows(n) =
      (0.5 * mesh.points.topRows(n)).rowwise() + Eigen::RowVector3d(5, 0, 0);
  mesh.faces.conservativeResize(2 * m, 3);
  mesh.faces.bottomRows(m) = mesh.faces.topRows(m).array() + n;
  return mesh;
}

TEST(Arap, TwoPartsTurnTogetherAsOneBody) {
  const Mesh mesh = TwoSpheres();
  Similarity3 motion;
  motion.rotation = Turn(1.5, {0, 0, 1});
  motion.translation << 1, 2, 3;
  const PointsX3 frame =
      ArapInterpolator(mesh.points, Transformed(motion, mesh.points), mesh.faces).At(0.5);
  const Similarity3 fit = FitSimilarity(mesh.points, frame, {}, false);
  EXPECT_LT(Gap(Transformed(fit, mesh.points), frame), 1e-10);
}

TEST(Arap, EachPartIsCentredOnItsOwnPath) {
  const Mesh mesh = TwoSpheres();
  const int n = mesh.vertex_count() / 2;
  PointsX3 u = mesh.points;
  u.bottomRows(n).col(0).array() += 2;  // the second part is translated, nothing turns
  const PointsX3 frame = ArapInterpolator(mesh.points, u, mesh.faces).At(0.5);
  EXPECT_LT((frame.topRows(n) - mesh.points.topRows(n)).norm(), 1e-10);
  EXPECT_NEAR(frame.bottomRows(n).col(0).mean(), 6, 1e-10);
}

TEST(Arap, SameBitsAtOneAndTwoThreads) {
  const Keys keys;
  SetThreadCount(1);
  const PointsX3 one = ArapInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).At(0.4);
  SetThreadCount(2);
  const PointsX3 two = ArapInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).At(0.4);
  SetThreadCount(0);
  EXPECT_EQ(one, two);
}

TEST(Arap, BendBeyondHalfATurnKeepsItsAreaWhenTurnsFollow) {
  const Mesh mesh = MakeCylinder(0.12, 2, 16, 80);
  const PointsX3 u = Bent(mesh.points, 2, 270 * kPi / 180);
  const auto distortion = [&](bool follow) {
    const PointsX3 frame =
        ArapInterpolator(mesh.points, u, mesh.faces, {.follow_turns = follow}).At(0.5);
    return std::abs(
        SurfaceArea(frame, mesh.faces) /
            std::sqrt(SurfaceArea(mesh.points, mesh.faces) * SurfaceArea(u, mesh.faces)) -
        1);
  };
  EXPECT_LT(distortion(true), 2e-3);
  EXPECT_GT(distortion(false), 4 * distortion(true));
}

TEST(Arap, FacesWithoutAreaAreHeldByTheirNeighbours) {
  Keys keys;
  // collapses the faces at one edge
  keys.u.row(keys.mesh.faces(100, 1)) = keys.u.row(keys.mesh.faces(100, 0));
  const ArapInterpolator arap(keys.mesh.points, keys.u, keys.mesh.faces);
  EXPECT_GE(arap.degenerate_faces(), 1);
  EXPECT_TRUE(arap.At(0.5).allFinite());
  EXPECT_LT(Gap(arap.At(1), keys.u), 1e-9);
  EXPECT_THROW(PaperInterpolator(keys.mesh.points, keys.u, keys.mesh.faces), InputError);
}

TEST(Arap, BadKeysThrowInputError) {
  const Mesh mesh = MakeIcosphere(1);
  PointsX3 nan = mesh.points;
  nan(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ArapInterpolator(mesh.points, nan, mesh.faces), InputError);
  EXPECT_THROW(ArapInterpolator(mesh.points, mesh.points.topRows(5), mesh.faces), InputError);
  EXPECT_THROW(ArapInterpolator(PointsX3(0, 3), PointsX3(0, 3), FacesX3(0, 3)), InputError);
  EXPECT_THROW(PaperInterpolator(mesh.points, nan, mesh.faces), InputError);
}

}  // namespace keypose::interpolation::surface_test
