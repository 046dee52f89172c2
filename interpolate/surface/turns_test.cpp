// Directions in which faces turn: consistent turns, overrides, relative rotations.
#include "interpolate/turns/turns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <iterator>
#include <numbers>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "deform/solvers/lanes.h"
#include "interpolate/surface/arap.h"
#include "interpolate/turns/differential_turns.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::interpolation::turns_test {

constexpr double kPi = std::numbers::pi;
constexpr double kLength = 2;

PointsX3 Twisted(const PointsX3& points, double degrees, double from = 0) {
  PointsX3 twisted = points;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = std::max(0.0, points(i, 2) - from) / (kLength - from) * degrees * kPi / 180;
    twisted.row(i) << std::cos(a) * points(i, 0) - std::sin(a) * points(i, 1),
        std::sin(a) * points(i, 0) + std::cos(a) * points(i, 1), points(i, 2);
  }
  return twisted;
}

double TwistOfTop(const PointsX3& start, const PointsX3& frame, int segments, int rings) {
  const int first = rings * segments;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
  for (int k = 0; k < segments; ++k) a += start.row(first + k), b += frame.row(first + k);
  const Eigen::RowVector3d u = start.row(first) - a.transpose() / segments,
                           v = frame.row(first) - b.transpose() / segments;
  return std::atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]) * 180 / kPi;
}

TEST(FollowTurns, KeepsEveryRotationToAThousandDegrees) {
  const Mesh mesh = MakeCylinder(0.08, kLength, 12, 60);
  const PointsX3 end = Twisted(mesh.points, 1000);
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  const TurnReport report = FollowTurns(system, maps);
  EXPECT_FALSE(report.differential);
  EXPECT_EQ(report.torn_edges, 0);
  // Any region whose rotation is a whole number of turns may be the body; from end to end the tube
  // turns by the full angle.
  double least = 0, most = 0;
  for (const FaceMap& map : maps.faces)
    least = std::min(least, map.turn[2]), most = std::max(most, map.turn[2]);
  EXPECT_NEAR(most - least, 1000 * kPi / 180, 1000 * kPi / 180 / 60);  // a ring of faces
  const Eigen::Matrix3d body = ExpOf(maps.body_turn);
  for (const FaceMap& map : maps.faces)
    EXPECT_LT((body * ExpOf(map.turn) * ExpOf(map.remainder) - map.rotation).norm(), 1e-9);
}

TEST(FollowTurns, RemaindersLieAcrossTheTurns) {
  const Mesh mesh = MakeCylinder(0.12, kLength, 12, 40);
  const PointsX3 end = Twisted(mesh.points, 300);
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  FollowTurns(system, maps);
  for (const FaceMap& map : maps.faces)
    if (map.turn.norm() > 0.5) {
      EXPECT_LT(std::abs(map.turn.normalized().dot(map.remainder)), 1e-9);
    }
}

TEST(FollowTurns, BodyIsWhatMostFacesTurnWith) {
  // Two thirds of the tube turn rigidly by 70 degrees; the rest twists by 200 more.
  const Mesh mesh = MakeCylinder(0.12, kLength, 12, 40);
  const Eigen::Vector3d turn = 70 * kPi / 180 * Eigen::Vector3d(1, 2, 2) / 3;
  const PointsX3 end = Twisted(mesh.points, 200, 1.3) * ExpOf(turn).transpose();
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  FollowTurns(system, maps);
  EXPECT_LT((maps.body_turn - turn).norm(), 0.02);
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

TEST(DifferentialTurns, GivesTheSameWayWhereBothServe) {
  const Mesh mesh = MakeCylinder(0.08, kLength, 12, 60);
  const PointsX3 end = Twisted(mesh.points, 400);
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  FollowTurns(system, maps);
  const DifferentialTurns differential(system, maps);
  double worst = 0;
  const std::vector<Eigen::Matrix3d> half = differential.At(0.5), whole = differential.At(1);
  const Eigen::Matrix3d body = ExpOf(maps.body_turn);
  for (std::size_t f = 0; f < half.size(); ++f) {
    EXPECT_LT((body * whole[f] - maps.faces[f].rotation).norm(), 1e-9);
    worst = std::max(
        worst,
        (half[f] - ExpOf(0.5 * maps.faces[f].turn) * ExpOf(0.5 * maps.faces[f].remainder)).norm());
  }
  EXPECT_LT(worst, 0.15);
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

TEST(Lanes, ElementaryFunctionsAreThoseOfTheLibrary) {
  double worst_sine = 0, worst_exp = 0;
  for (int k = -40000; k < 40000; ++k) {
    const double x = 0.00173 * k;
    Lanes sine, cosine;
    plain::SinCos(plain::Spread(x), sine, cosine);
    worst_sine =
        std::max({worst_sine, std::abs(sine[1] - std::sin(x)), std::abs(cosine[2] - std::cos(x))});
    worst_exp = std::max(worst_exp, std::abs(plain::Exp(plain::Spread(x))[3] / std::exp(x) - 1));
  }
  EXPECT_LT(worst_sine, 4e-16);
  EXPECT_LT(worst_exp, 1e-15);
}

}  // namespace keypose::interpolation::turns_test
