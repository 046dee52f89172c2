#include "interpolate/surface/face_paths.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "interpolate/surface/arap.h"
#include "interpolate/turns/differential_turns.h"
#include "interpolate/turns/testing/twisted_bar.h"
#include "interpolate/turns/turns.h"

namespace keypose::interpolation::face_paths_test {

double TwistOfTop(const PointsX3& start, const PointsX3& frame, int segments, int rings) {
  const int first = rings * segments;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
  for (int k = 0; k < segments; ++k) a += start.row(first + k), b += frame.row(first + k);
  const Eigen::RowVector3d u = start.row(first) - a.transpose() / segments,
                           v = frame.row(first) - b.transpose() / segments;
  return std::atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]) * 180 / kPi;
}

TEST(TurnOverride, AddsWholeTurnsAndReversesWithTheKeys) {
  const int segments = 12, rings = 40;
  const Mesh mesh = MakeCylinder(0.12, kLength, segments, rings);
  const PointsX3 end = Twisted(mesh.points, 60, 1.6);
  std::vector<int> limb;
  for (int f = 0; f < mesh.face_count(); ++f)
    if (mesh.points(mesh.faces(f, 0), 2) > 0.95) limb.push_back(f);
  ArapOptions options;
  EXPECT_NEAR(
      TwistOfTop(mesh.points, ArapInterpolator(mesh.points, end, mesh.faces, options).At(0.5),
                 segments, rings),
      30, 1);
  options.turn_overrides = {
      {.name = "propeller", .faces = limb, .extra_turns = 1, .axis = {0, 0, 1}}};
  const ArapInterpolator spun(mesh.points, end, mesh.faces, options);
  EXPECT_NEAR(TwistOfTop(mesh.points, spun.At(0.25), segments, rings), 105, 3);  // a quarter of 420
  EXPECT_EQ(spun.At(1), end);
  options.turn_overrides[0].extra_turns = -1;
  EXPECT_NEAR(
      TwistOfTop(mesh.points, ArapInterpolator(mesh.points, end, mesh.faces, options).At(0.25),
                 segments, rings),
      -75, 3);
  // From the other key the same motion is the opposite turn about the same axis.
  options.turn_overrides[0].extra_turns = 1;
  options.turn_overrides[0].axis = {0, 0, -1};
  const ArapInterpolator back(end, mesh.points, mesh.faces, options);
  EXPECT_LT((back.At(0.75) - spun.At(0.25)).rowwise().norm().maxCoeff(), 1e-9);
}

TEST(TurnOverride, OneFaceNamesItsRigidClusterAndBadOnesAreNamed) {
  const int segments = 12, rings = 40;
  const Mesh mesh = MakeCylinder(0.12, kLength, segments, rings);
  PointsX3 end = mesh.points;
  // The upper half turns rigidly by 100 degrees, all within one row of faces.
  for (Eigen::Index i = 0; i < end.rows(); ++i)
    if (end(i, 2) > 1.01) end.row(i) = end.row(i) * ExpOf({0, 0, 100 * kPi / 180}).transpose();
  int face = 0;
  while (mesh.points(mesh.faces(face, 0), 2) < 1.5) ++face;
  ArapOptions options;
  options.turn_overrides = {{.name = "top", .faces = {face}, .extra_turns = -1}};
  const PointsX3 frame = ArapInterpolator(mesh.points, end, mesh.faces, options).At(0.25);
  EXPECT_NEAR(TwistOfTop(mesh.points, frame, segments, rings), -65, 5);  // a quarter of 100 - 360
  options.turn_overrides[0].faces = {-3};
  EXPECT_THROW(ArapInterpolator(mesh.points, end, mesh.faces, options), InputError);
  options.turn_overrides[0].faces = {};
  EXPECT_THROW(ArapInterpolator(mesh.points, end, mesh.faces, options), InputError);
  options.turn_overrides[0].faces = {face};
  EXPECT_THROW(ArapInterpolator(mesh.points, mesh.points, mesh.faces, options),
               InputError);  // nothing turns: no axis
}

TEST(HalfTurn, GoesTheWayRoundThatDoesNotPassThroughTheBody) {
  // A plate beside a block, hinged at a shared edge, folds over onto the block: upwards is free,
  // downwards is not.
  Mesh mesh;
  PointsX3 end;
  const int n = 8;
  for (int side = 0; side < 2; ++side)
    for (int j = 0; j <= n; ++j)
      for (int i = side; i <= n; ++i) {
        const double x = side == 0 ? -1.0 + static_cast<double>(i) / n : static_cast<double>(i) / n,
                     y = static_cast<double>(j) / n;
        mesh.points.conservativeResize(mesh.points.rows() + 1, 3);
        end.conservativeResize(end.rows() + 1, 3);
        mesh.points.bottomRows(1) << x, y, 0;
        end.bottomRows(1) << (side == 0 ? x : -0.999 * x), y, 0.001 * (side == 1);
      }
  const auto at = [&](int i, int j) {
    return i <= n ? j * (n + 1) + i : (n + 1) * (n + 1) + j * n + (i - n - 1);
  };
  std::vector<Eigen::RowVector3i> faces;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < 2 * n; ++i) {
      faces.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      faces.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  // A wall blocks one of the two directions of the plate; first below, then above.
  for (double wall : {-0.5, 0.5}) {
    Mesh body = mesh;
    PointsX3 second = end;
    const int base = body.vertex_count();
    body.points.conservativeResize(base + 4, 3);
    body.points.bottomRows(4) << -0.3, 0.2, wall, 0.3, 0.2, wall, 0.3, 0.8, wall, -0.3, 0.8, wall;
    second.conservativeResize(base + 4, 3);
    second.bottomRows(4) = body.points.bottomRows(4);
    body.faces.resize(std::ssize(faces) + 2, 3);
    for (std::size_t f = 0; f < faces.size(); ++f) body.faces.row(f) = faces[f];
    body.faces.bottomRows(2) << base, base + 1, base + 2, base, base + 2, base + 3;
    const ArapInterpolator arap(body.points, second, body.faces);
    EXPECT_EQ(arap.report().turns.half_turns.size() + arap.report().half_turns.size() > 0, true);
    const PointsX3 frame = arap.At(0.5);
    EXPECT_GT(frame(at(2 * n, n / 2), 2) * (wall < 0 ? 1 : -1), 0.5) << wall;
  }
}

TEST(DifferentialTurns, TakesOverWhereTurnsDoNotClose) {
  // A ring whose tube is twisted by a whole turn around the ring: rotations wind once, and no
  // rotation vectors are consistent everywhere.
  const int along = 120, around = 12;
  Mesh mesh;
  PointsX3 end(along * around, 3);
  mesh.points.resize(along * around, 3);
  const auto at = [&](int i, int k) { return (i % along) * around + k % around; };
  for (int i = 0; i < along; ++i)
    for (int k = 0; k < around; ++k) {
      const double s = 2 * kPi * i / along, a = 2 * kPi * k / around;
      const auto point = [&](double angle) {
        const double r = 1 + 0.15 * std::cos(angle);
        return Eigen::RowVector3d(r * std::cos(s), r * std::sin(s), 0.15 * std::sin(angle));
      };
      mesh.points.row(at(i, k)) = point(a);
      end.row(at(i, k)) = point(a + s);
    }
  mesh.faces.resize(2 * along * around, 3);
  for (int i = 0, f = 0; i < along; ++i)
    for (int k = 0; k < around; ++k) {
      mesh.faces.row(f++) << at(i, k), at(i + 1, k), at(i + 1, k + 1);
      mesh.faces.row(f++) << at(i, k), at(i + 1, k + 1), at(i, k + 1);
    }
  const ArapInterpolator arap(mesh.points, end, mesh.faces);
  const TurnReport& report = arap.report().turns;
  EXPECT_GT(report.loops_that_do_not_close, 0);
  const PointsX3 frame = arap.At(0.5);
  EXPECT_TRUE(frame.allFinite());
  EXPECT_NEAR(SignedVolume(frame, mesh.faces) /
                  std::sqrt(SignedVolume(mesh.points, mesh.faces) * SignedVolume(end, mesh.faces)),
              1, 1e-8);
}

}  // namespace keypose::interpolation::face_paths_test
