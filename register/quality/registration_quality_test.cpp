#include "register/quality/registration_quality.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::registration::registration_quality_test {

TEST(MeasureRegistration, TheSourceOnItselfIsPerfect) {
  const Mesh sphere = MakeIcosphere(4);
  const RegistrationQuality q = MeasureRegistration(sphere, sphere.points, sphere);
  EXPECT_LT(q.surface_rms, 1e-12);
  EXPECT_LT(q.hausdorff_to_target, 1e-12);
  EXPECT_LT(q.hausdorff_from_target, 1e-12);
  EXPECT_EQ(q.flipped, 0);
  EXPECT_EQ(q.degenerate, 0);
  EXPECT_EQ(q.self_intersections, 0);
  EXPECT_EQ(q.self_intersections_gained, 0);
  EXPECT_EQ(q.coverage, 1);
  EXPECT_NEAR(q.stretch.smallest, 1, 1e-9);
  EXPECT_NEAR(q.stretch.largest, 1, 1e-9);
  EXPECT_NEAR(q.stretch.worst_ratio, 1, 1e-6);
}

TEST(MeasureRegistration, ConcentricSpheresAreApartByTheDifferenceOfTheirRadii) {
  const Mesh sphere = MakeIcosphere(5);
  const PointsX3 larger = 1.05 * sphere.points;
  const RegistrationQuality q = MeasureRegistration(sphere, larger, sphere);
  const double expected = 0.05 / BoundingDiagonal(sphere.points);
  EXPECT_NEAR(q.surface_mean, expected, 2e-3 * expected);  // faces are flat
  EXPECT_NEAR(q.surface_rms, expected, 2e-3 * expected);
  EXPECT_NEAR(q.hausdorff_to_target, expected, 1e-3 * expected);
  EXPECT_EQ(q.coverage, 0);  // 1.4 % of the diagonal apart
  EXPECT_NEAR(q.stretch.high, 1, 1e-9);
  EXPECT_EQ(MeasureRegistration(sphere, 1.01 * sphere.points, sphere).coverage, 1);
}

TEST(MeasureRegistration, AnInvertedSurfaceIsAllFlippedAndCoversNothing) {
  const Mesh sphere = MakeIcosphere(3);
  Mesh inverted = sphere;
  inverted.faces.col(1).swap(inverted.faces.col(2));
  const RegistrationQuality q = MeasureRegistration(inverted, sphere.points, sphere);
  EXPECT_EQ(q.flipped, sphere.face_count());
  EXPECT_EQ(q.coverage, 0);
}

/// Two square sheets whose outer sides face away from each other: one at z = `height`, one at 0.
Mesh TwoSheets(double height) {
  constexpr int kSide = 21;
  Mesh mesh;
  mesh.points.resize(2 * kSide * kSide, 3);
  mesh.faces.resize(4 * (kSide - 1) * (kSide - 1), 3);
  Eigen::Index face = 0;
  for (int sheet = 0; sheet < 2; ++sheet)
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        const int a = (sheet * kSide + i) * kSide + j, b = a + kSide;
        mesh.points.row(a) << i / (kSide - 1.0), j / (kSide - 1.0), sheet * height;
        if (i + 1 == kSide || j + 1 == kSide) continue;
        mesh.faces.row(face++) << a, (sheet ? b : a + 1), (sheet ? a + 1 : b);
        mesh.faces.row(face++) << a + 1, (sheet ? b : b + 1), (sheet ? b + 1 : b);
      }
  return mesh;
}

TEST(MeasureRegistration, AFaceIsClearlyFlippedWhereItsOwnWallIsClearlyFarther) {
  constexpr double kGap = 0.1;
  const Mesh target = TwoSheets(kGap);
  const double slack = 0.002 * BoundingDiagonal(target.points);
  // The upper sheet is so low that the lower one is nearer, once by less and once by more than the
  // slack.
  const Mesh doubtful = TwoSheets(kGap / 2 - 0.49 * slack),
             flipped = TwoSheets(kGap / 2 - 0.51 * slack);
  EXPECT_EQ(MeasureRegistration(target, target.points, target).flipped_clearly, 0);
  EXPECT_EQ(MeasureRegistration(target, doubtful.points, target).flipped_clearly, 0);
  EXPECT_EQ(MeasureRegistration(target, flipped.points, target).flipped_clearly,
            target.face_count() / 2);
  // By the nearest face alone both are flipped.
  EXPECT_EQ(MeasureRegistration(target, doubtful.points, target).flipped, target.face_count() / 2);
}

TEST(MeasureRegistration, HalfTheTargetIsHalfCovered) {
  const Mesh sphere = MakeIcosphere(5);
  Mesh half = sphere;
  half.faces.resize(0, 3);
  std::vector<int> upper;
  for (int f = 0; f < sphere.face_count(); ++f) {
    const double z = sphere.points(sphere.faces(f, 0), 2) + sphere.points(sphere.faces(f, 1), 2) +
                     sphere.points(sphere.faces(f, 2), 2);
    if (z > 0) upper.push_back(f);
  }
  half.faces.resize(std::ssize(upper), 3);
  for (std::size_t i = 0; i < upper.size(); ++i) half.faces.row(i) = sphere.faces.row(upper[i]);
  // 1 % of the diagonal is 0.035 radii. This band increases the covered share by 0.017.
  EXPECT_NEAR(MeasureRegistration(half, half.points, sphere).coverage, 0.5 + 0.0173, 0.01);
}

TEST(MeasureRegistration, SelfIntersectionsAreCountedAgainstTheSource) {
  const Mesh tube = MakeCylinder(0.2, 4, 16, 40);
  // The tube is folded back through itself: the part beyond the middle is mirrored.
  PointsX3 folded = tube.points;
  for (Eigen::Index i = 0; i < folded.rows(); ++i)
    if (folded(i, 2) > 2) {
      folded(i, 0) += 0.1;
      folded(i, 2) = 4 - folded(i, 2);
    }
  const RegistrationQuality q = MeasureRegistration(tube, folded, tube);
  EXPECT_GT(q.self_intersections_gained, 100);
  Mesh crossing = tube;
  crossing.points = folded;
  const RegistrationQuality undone = MeasureRegistration(crossing, tube.points, tube);
  EXPECT_EQ(undone.self_intersections, 0);
  EXPECT_EQ(undone.self_intersections_gained, -q.self_intersections);
}

TEST(MeasureStretch, AffineMapOfAPlaneHasItsSingularValues) {
  Mesh plane;
  plane.points.resize(4, 3);
  plane.points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
  plane.faces.resize(2, 3);
  plane.faces << 0, 1, 2, 0, 2, 3;
  const Eigen::AngleAxisd turn(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  Eigen::Matrix3d map = turn.toRotationMatrix() * Eigen::Vector3d(3, 0.5, 1).asDiagonal();
  const Stretch s = MeasureStretch(plane, plane.points * map.transpose());
  const double scale = std::sqrt(1.5);  // the change of size
  EXPECT_NEAR(s.largest, 3 / scale, 1e-12);
  EXPECT_NEAR(s.smallest, 0.5 / scale, 1e-12);
  EXPECT_NEAR(s.worst_ratio, 6, 1e-10);
  EXPECT_NEAR(MeasureStretch(plane, 7 * plane.points).largest, 1, 1e-12);
}

TEST(MeasureStretch, ACollapsedFaceHasTheLargestRatioAndNoNan) {
  Mesh sphere = MakeIcosphere(2);
  PointsX3 collapsed = sphere.points;
  collapsed.row(sphere.faces(0, 0)) = collapsed.row(sphere.faces(0, 1));
  const Stretch s = MeasureStretch(sphere, collapsed);
  EXPECT_EQ(s.worst_ratio, 1e6);
  EXPECT_EQ(s.smallest, 0);
  EXPECT_TRUE(std::isfinite(s.largest));
  const RegistrationQuality point =
      MeasureRegistration(sphere, PointsX3::Zero(sphere.vertex_count(), 3), sphere);
  EXPECT_EQ(point.degenerate, sphere.face_count());
  EXPECT_TRUE(std::isfinite(point.surface_rms) && std::isfinite(point.stretch.high) &&
              std::isfinite(point.coverage));
}

TEST(MeasureRegistration, SameBitsAtAnyThreadCount) {
  const Mesh sphere = MakeIcosphere(4), tube = MakeCylinder(0.8, 2, 40, 40);
  const auto at = [&](int threads) {
    SetThreadCount(threads);
    const RegistrationQuality q = MeasureRegistration(sphere, sphere.points, tube);
    const std::vector<LandmarkAdvice> advice = AdviseLandmarks(sphere, sphere.points, tube, {});
    SetThreadCount(0);
    return std::tuple(q.surface_rms, q.surface_mean, q.hausdorff_from_target, q.coverage, q.flipped,
                      q.stretch.high, advice.at(0).vertex, advice.at(0).score);
  };
  EXPECT_EQ(at(1), at(4));
}

TEST(MeasureRegistration, AnotherVertexCountThrows) {
  const Mesh sphere = MakeIcosphere(2);
  EXPECT_THROW(MeasureRegistration(sphere, PointsX3::Zero(3, 3), sphere), InputError);
  EXPECT_THROW(MeasureStretch(sphere, PointsX3::Zero(3, 3)), InputError);
  EXPECT_THROW(AdviseLandmarks(sphere, PointsX3::Zero(3, 3), sphere, {}), InputError);
  PointsX3 bad = sphere.points;
  bad(0, 0) = std::nan("");
  EXPECT_THROW(MeasureRegistration(sphere, bad, sphere), InputError);
  EXPECT_THROW(AdviseLandmarks(sphere, bad, sphere, {}), InputError);
}

TEST(MeasureRegistration, CountsFlipsAndDistances) {
  const Mesh mesh = MakeIcosphere(3);
  const RegistrationQuality same = MeasureRegistration(mesh, mesh.points, mesh);
  EXPECT_EQ(same.flipped, 0);
  EXPECT_LT(same.surface_rms, 1e-12);
  EXPECT_LT(same.hausdorff_from_target, 1e-12);
  Mesh inside_out = mesh;
  inside_out.faces.col(1).swap(inside_out.faces.col(2));
  EXPECT_EQ(MeasureRegistration(mesh, mesh.points, inside_out).flipped, mesh.face_count());
  const RegistrationQuality grown = MeasureRegistration(mesh, 1.1 * mesh.points, mesh);
  EXPECT_NEAR(grown.hausdorff_to_target, 0.1 / BoundingDiagonal(mesh.points), 1e-3);
  EXPECT_NEAR(grown.surface_rms, 0.1 / BoundingDiagonal(mesh.points), 1e-3);
}

}  // namespace keypose::registration::registration_quality_test
