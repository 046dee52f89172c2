#include "interpolate/volume/volumetric.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>

#include "core/camera.h"
#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/testing_shapes.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/maps/matrix_powers.h"
#include "interpolate/surface/arap.h"
#include "interpolate/volume/graph_turns.h"
#include "interpolate/volume/place_inside.h"
#include "interpolate/volume/tet_maps.h"
#include "interpolate/volume/tet_paths.h"
#include "interpolate/volume/tetrahedralize.h"

namespace keypose::interpolation {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Matrix3d Turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}
double Gap(const PointsX3& a, const PointsX3& b) {
  return (a - b).rowwise().norm().maxCoeff() / BoundingDiagonal(b);
}
bool SameBits(const PointsX3& a, const PointsX3& b) {
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

/// A bar of length 2 along z, round or square across.
struct Bar {
  static constexpr int kSegments = 24, kRings = 40;
  explicit Bar(double radius, bool square = false)
      : mesh(MakeCylinder(radius, 2, kSegments, kRings)) {
    if (!square) return;
    for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) {
      const double reach = std::max(std::abs(mesh.points(i, 0)), std::abs(mesh.points(i, 1)));
      if (reach > 0) mesh.points.row(i).head<2>() *= radius / reach;
    }
  }

  PointsX3 Twisted(double angle) const {
    PointsX3 p = mesh.points;
    for (Eigen::Index i = 0; i < p.rows(); ++i)
      p.row(i) *= Turn(angle * p(i, 2) / 2, Eigen::Vector3d::UnitZ()).transpose();
    return p;
  }
  PointsX3 Bent(double angle) const {
    PointsX3 p = mesh.points;
    const double radius = 2 / angle;
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const double a = mesh.points(i, 2) / radius, r = radius - mesh.points(i, 0);
      p.row(i) << radius - r * std::cos(a), mesh.points(i, 1), r * std::sin(a);
    }
    return p;
  }
  /// Area of each ring of vertices, except the two at either end, whose shape the caps determine.
  std::vector<double> CrossSections(const PointsX3& p) const {
    std::vector<double> areas;
    for (int r = 2; r <= kRings - 2; ++r) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int s = 0; s < kSegments; ++s) {
        const Eigen::Vector3d a = p.row(r * kSegments + s) - p.row(r * kSegments),
                              b = p.row(r * kSegments + (s + 1) % kSegments) - p.row(r * kSegments);
        sum += a.cross(b);
      }
      areas.push_back(0.5 * sum.norm());
    }
    return areas;
  }
  double SmallestCrossSection(const PointsX3& p) const {
    const std::vector<double> now = CrossSections(p), rest = CrossSections(mesh.points);
    double least = 1e9;
    for (std::size_t r = 0; r < now.size(); ++r) least = std::min(least, now[r] / rest[r]);
    return least;
  }
  Mesh mesh;
};

double SolidVolume(const Solid& solid) {
  double sum = 0;
  for (const TetShape& shape : TetShapesOf(solid.points, solid.tets)) sum += shape.volume;
  return sum;
}

void Join(Mesh& mesh, const Mesh& other) {
  const int v = mesh.vertex_count(), f = mesh.face_count();
  mesh.points.conservativeResize(v + other.vertex_count(), 3);
  mesh.points.bottomRows(other.vertex_count()) = other.points;
  mesh.faces.conservativeResize(f + other.face_count(), 3);
  mesh.faces.bottomRows(other.face_count()) = other.faces.array() + v;
}

/// A ball with a ball-shaped hollow.
Mesh HollowBall() {
  Mesh mesh = MakeIcosphere(2), hollow = MakeIcosphere(2);
  hollow.points *= 0.5;
  hollow.faces.col(1).swap(hollow.faces.col(2));
  Join(mesh, hollow);
  return mesh;
}

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no InputError";
}

TEST(Tetrahedralize, FillsTheSurfaceAndKeepsItsVertices) {
  for (const Mesh& mesh : {MakeBox(1, 2, 3), MakeIcosphere(3), Bar(0.2, true).mesh, HollowBall()}) {
    const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
    EXPECT_TRUE(SameBits(solid.points.topRows(mesh.vertex_count()), mesh.points));
    EXPECT_NEAR(SolidVolume(solid), SignedVolume(mesh.points, mesh.faces),
                1e-12 * BoundingDiagonal(mesh.points));
    for (const TetShape& shape : TetShapesOf(solid.points, solid.tets)) EXPECT_GT(shape.volume, 0);
    for (Eigen::Index t = 0; t < solid.tets.rows(); ++t)
      for (int n : solid.opposite[t])
        if (n >= 0) {
          EXPECT_THAT(solid.opposite[n], testing::Contains(static_cast<int>(t)));
        }
  }
}

TEST(Tetrahedralize, BodiesThatOverlapAreFilledEachForItself) {
  Mesh mesh = MakeIcosphere(2), eye = MakeIcosphere(1);
  eye.points *= 0.3;
  eye.points.rowwise() += Eigen::RowVector3d(1, 0, 0);
  Join(mesh, eye);
  const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
  EXPECT_EQ(solid.bodies, 2);
  EXPECT_NEAR(SolidVolume(solid), SignedVolume(mesh.points, mesh.faces), 1e-12);
}

TEST(Tetrahedralize, SmallerElementsGiveMoreTetrahedraUpToTheLimit) {
  const Mesh mesh = MakeIcosphere(3);
  const auto count = [&](double size, int most) {
    return Tetrahedralize(mesh.points, mesh.faces, "test",
                          {.element_size = size, .max_tetrahedra = most})
        .tets.rows();
  };
  EXPECT_GT(count(0.5, 50000), 2 * count(1, 50000));
  EXPECT_LT(count(0.2, 20000), 40000);
}

TEST(Tetrahedralize, NamesWhatKeepsASurfaceFromBeingFilled) {
  const auto fault = [](const Mesh& mesh) {
    return MessageOf([&] { Tetrahedralize(mesh.points, mesh.faces, "pose"); });
  };
  Mesh open = MakeBox(1, 1, 1);
  open.faces.conservativeResize(11, 3);
  EXPECT_THAT(fault(open),
              testing::AllOf(testing::HasSubstr("pose: the surface is not closed: 3 edges"),
                             testing::HasSubstr("keypose-cleanup")));
  Mesh flat = MakeBox(1, 1, 1);
  flat.points.row(0) = flat.points.row(1);
  EXPECT_THAT(fault(flat), testing::HasSubstr("has no area"));
  Mesh inside_out = MakeBox(1, 1, 1);
  inside_out.faces.col(1).swap(inside_out.faces.col(2));
  EXPECT_THAT(fault(inside_out), testing::HasSubstr("inside out"));
  Mesh crossing = Bar(0.1).mesh;  // curled up, intersecting itself
  crossing.points = Bar(0.1).Bent(2.3 * kPi);
  EXPECT_THAT(fault(crossing),
              testing::HasSubstr("passes through itself, where the face of vertices"));
}

TEST(ClosestRotation, EqualsSingularValuesAlsoForMirroredAndFlatMaps) {
  for (int k = 0; k < 2000; ++k) {
    const auto wave = [&](double f) { return std::sin(f * (k + 1)); };
    Eigen::Matrix3d j;
    j << wave(1.1), wave(2.3), wave(3.7), wave(0.9), wave(5.1), wave(1.7), wave(2.9), wave(4.3),
        wave(0.7);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(j),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (svd.singularValues()[1] - svd.singularValues()[2] < 1e-3)
      continue;  // not unique for a mirrored one
    Eigen::Vector3d sign = Eigen::Vector3d::Ones();
    sign[2] = (svd.matrixU() * svd.matrixV()).determinant() > 0 ? 1 : -1;
    EXPECT_LT(
        (ClosestRotation(j) - svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose()).norm(),
        1e-10);
  }
  EXPECT_LT(
      (ClosestRotation(Eigen::Vector3d(2, 3, 0).asDiagonal()) - Eigen::Matrix3d::Identity()).norm(),
      1e-12);
}

TEST(LogOfMatrix, IsTheInverseOfTheExponentialAndKnowsShears) {
  for (int k = 0; k < 500; ++k) {
    const auto wave = [&](double f) { return 0.8 * std::sin(f * (k + 1)); };
    Eigen::Matrix3d log;
    log << wave(1.1), wave(2.3), wave(3.7), wave(0.9), wave(5.1), wave(1.7), wave(2.9), wave(4.3),
        wave(0.7);
    const std::optional<Eigen::Matrix3d> back = LogOfMatrix(ExpOfMatrix(log));
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - log).norm(), 1e-11);
    for (double t : {-1.3, 0.1, 0.7, 3.0})
      EXPECT_LT((MatrixExponential(log).At(t) - ExpOfMatrix(t * log)).norm(),
                1e-13 * ExpOfMatrix(t * log).norm());
  }
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 5;
  EXPECT_LT((*LogOfMatrix(shear) - (shear - Eigen::Matrix3d::Identity())).norm(), 1e-12);
  EXPECT_FALSE(LogOfMatrix(-Eigen::Matrix3d::Identity()).has_value());
}

TEST(TetPath, AShearStaysAShearAndABendedFibreGrowsEvenly) {
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 2;
  const Eigen::Vector3d turn(0, 0, 3);
  Eigen::Matrix3d quarter = Eigen::Matrix3d::Identity();
  quarter(0, 2) = 0.5;
  EXPECT_LT((TetPath(ExpOf(turn) * shear, turn, 0).At(0.25) - ExpOf(0.25 * turn) * quarter).norm(),
            1e-12);
  const Eigen::Matrix3d fibre = Eigen::Vector3d(1, 1, 0.4).asDiagonal(),
                        half = Eigen::Vector3d(1, 1, 0.7).asDiagonal();
  EXPECT_LT((TetPath(ExpOf(turn) * fibre, turn, 0).At(0.5) - ExpOf(0.5 * turn) * half).norm(),
            1e-12);
}

TEST(TetPath, ReachesWhatHasNoLogarithm) {
  for (const Eigen::Vector3d& stretch : {Eigen::Vector3d(1, 2, -0.5), Eigen::Vector3d(1, 2, 0)}) {
    const Eigen::Matrix3d map = Turn(3, {1, 1, 0}) * stretch.asDiagonal();
    const TetPath path(map, {0.1, 0.2, 0.3}, 0.1);
    EXPECT_FALSE(path.has_power());
    EXPECT_LT((path.At(0) - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT((path.At(1) - map).norm(), 1e-12);
  }
}

TEST(LiftTurns, AChainThatCoilsNearlyThreeTimesIsOneLongTurn) {
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<std::array<int, 4>> neighbours;
  const int count = 101;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d wobble(0.03 * std::sin(7.0 * i), 0.03 * std::cos(5.0 * i), 0);
    rotations.push_back(Turn(i * 10 * kPi / 180, Eigen::Vector3d::UnitZ()) * ExpOf(wobble));
    neighbours.push_back({i > 0 ? i - 1 : -1, i + 1 < count ? i + 1 : -1, -1, -1});
  }
  const LiftedTurns lifted = LiftTurns(rotations, 0, neighbours, std::vector<char>(count, 0));
  for (int i = 0; i < count; ++i) {
    EXPECT_NEAR(lifted.turns[i].norm(), i * 10 * kPi / 180, 0.1) << i;
    EXPECT_LT((ExpOf(lifted.turns[i]) * ExpOf(lifted.remainders[i]) - rotations[i]).norm(), 1e-12);
    EXPECT_LT(lifted.remainders[i].norm(), 0.2);
  }
  EXPECT_LT(lifted.largest_tear, 1);
}

TEST(LiftTurns, ARingThatTurnedInsideItselfIsReportedAsTorn) {
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<std::array<int, 4>> neighbours;
  for (int i = 0; i < 36; ++i) {
    rotations.push_back(Turn(i * 10 * kPi / 180, Eigen::Vector3d::UnitX()));
    neighbours.push_back({(i + 35) % 36, (i + 1) % 36, -1, -1});
  }
  EXPECT_NEAR(LiftTurns(rotations, 0, neighbours, std::vector<char>(36, 0)).largest_tear, 2 * kPi,
              0.5);
}

TEST(PlaceInside, UntanglesInnerPointsThatWerePushedThroughTheirNeighbours) {
  const Mesh mesh = MakeIcosphere(2);
  const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
  const std::vector<TetShape> shapes = TetShapesOf(solid.points, solid.tets);
  PointsX3 tangled = solid.points;
  for (Eigen::Index i = mesh.vertex_count(); i < tangled.rows(); i += 3)
    tangled.row(i) = 0.9 * tangled.row(i).reverse();
  int inverted = 0;
  for (Eigen::Index t = 0; t < solid.tets.rows(); ++t)
    inverted += MapOf(shapes[t], tangled, solid.tets, t).determinant() <= 0;
  EXPECT_GT(inverted, 50);
  EXPECT_EQ(Untangle(solid, shapes, mesh.vertex_count(), tangled), 0);
  EXPECT_TRUE(SameBits(tangled.topRows(mesh.vertex_count()), mesh.points));
}

TEST(PlaceInside, InnerPointsOfAnEvenlyStretchedSolidAreStretchedAlike) {
  const Mesh mesh = MakeIcosphere(2);
  const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
  const Eigen::Matrix3d map = Turn(2, {1, 2, 3}) * 1.7;
  const PointsX3 placed = PlaceInside(solid, TetShapesOf(solid.points, solid.tets), mesh.faces,
                                      mesh.points * map.transpose());
  EXPECT_LT(Gap(placed, solid.points * map.transpose()), 1e-12);
}

TEST(Volumetric, RigidMotionGivesRigidFrames) {
  const Bar bar(0.2);
  Similarity3 motion;
  motion.rotation = Turn(2.5, {1, 2, -1});
  motion.translation << 3, 1, -2;
  const VolumetricInterpolator solid(bar.mesh.points, Transformed(motion, bar.mesh.points),
                                     bar.mesh.faces);
  for (double t : {0.1, 0.37, 0.9}) {
    const PointsX3 frame = solid.At(t);
    for (const auto& [i, j] : UndirectedEdges(bar.mesh.faces))
      EXPECT_NEAR((frame.row(i) - frame.row(j)).norm(),
                  (bar.mesh.points.row(i) - bar.mesh.points.row(j)).norm(), 1e-10);
  }
}

TEST(Volumetric, UniformGrowthIsGeometricAndIdenticalKeysStayPut) {
  const Mesh mesh = MakeIcosphere(2);
  EXPECT_LT(Gap(VolumetricInterpolator(mesh.points, 3 * mesh.points, mesh.faces).At(0.25),
                std::pow(3, 0.25) * mesh.points),
            1e-11);
  const Bar bar(0.2);
  const PointsX3 bent = bar.Bent(2);
  EXPECT_LT(Gap(VolumetricInterpolator(bent, bent, bar.mesh.faces).At(0.4), bent), 1e-11);
}

TEST(Volumetric, MiddleOfATurnBy179DegreesIs89AndAHalf) {
  const Mesh mesh = MakeBox(1, 2, 3);
  const PointsX3 u = mesh.points * Turn(179 * kPi / 180, Eigen::Vector3d::UnitZ()).transpose();
  const PointsX3 frame = VolumetricInterpolator(mesh.points, u, mesh.faces).At(0.5),
                 centred = frame.rowwise() - frame.colwise().mean();
  const PointsX3 start = mesh.points.rowwise() - mesh.points.colwise().mean();
  EXPECT_LT(Gap(centred, start * Turn(89.5 * kPi / 180, Eigen::Vector3d::UnitZ()).transpose()),
            1e-11);
}

TEST(Volumetric, EndsHaveTheKeysBitsAndFramesNearThemComeClose) {
  const Bar bar(0.15);
  const PointsX3 u = bar.Bent(4);
  const VolumetricInterpolator solid(bar.mesh.points, u, bar.mesh.faces);
  EXPECT_TRUE(SameBits(solid.At(0), bar.mesh.points));
  EXPECT_TRUE(SameBits(solid.At(1), u));
  EXPECT_LT(Gap(solid.At(1e-9), bar.mesh.points), 1e-8);
  EXPECT_LT(Gap(solid.At(1 - 1e-9), u), 1e-8);
}

TEST(Volumetric, SwappingTheKeysReversesTime) {
  const Bar bar(0.15);
  const PointsX3 v = bar.Twisted(1), u = bar.Bent(4);
  const VolumetricInterpolator there(v, u, bar.mesh.faces), back(u, v, bar.mesh.faces);
  EXPECT_NE(there.report().meshed_key, back.report().meshed_key);
  EXPECT_TRUE(SameBits(there.At(0.25), back.At(0.75)));  // 1 - 0.25 is exact
  EXPECT_LT(Gap(there.At(0.3), back.At(0.7)), 1e-12);
}

/// Mean distance from the exact pose after the best rigid fit, over the diagonal.
double MeanError(const PointsX3& frame, const PointsX3& exact) {
  return (Transformed(FitSimilarity(frame, exact, {}, false), frame) - exact)
             .rowwise()
             .norm()
             .mean() /
         BoundingDiagonal(exact);
}

TEST(Volumetric, BendsBeyondAHalfTurnPassThroughTheHalfBend) {
  const Bar bar(0.12);
  // Degrees, and twice what was measured.
  for (const auto& [degrees, most] : {std::pair{150.0, 1e-4}, {300.0, 4e-4}, {450.0, 1e-3}}) {
    const double angle = degrees * kPi / 180;
    const VolumetricInterpolator solid(bar.mesh.points, bar.Bent(angle), bar.mesh.faces);
    EXPECT_LT(MeanError(solid.At(0.5), bar.Bent(angle / 2)), most) << degrees;
    EXPECT_EQ(solid.report().inverted, 0);
  }
}

TEST(Volumetric, StrongTwistsKeepTheirCrossSectionBetterThanASurfaceAlone) {
  const Bar bar(0.12, true);
  for (double turns : {1, 2}) {
    const PointsX3 u = bar.Twisted(2 * kPi * turns), half = bar.Twisted(kPi * turns);
    const PointsX3 frame = VolumetricInterpolator(bar.mesh.points, u, bar.mesh.faces).At(0.5);
    EXPECT_GT(bar.SmallestCrossSection(frame), 0.98) << turns;
    EXPECT_LT(MeanError(frame, half), 0.005) << turns;
    const PointsX3 shell = ArapInterpolator(bar.mesh.points, u, bar.mesh.faces).At(0.5);
    const PointsX3 paper =
        ArapInterpolator(bar.mesh.points, u, bar.mesh.faces, PaperOptions()).At(0.5);
    EXPECT_LT(bar.SmallestCrossSection(paper), 0.1)
        << turns << ": the paper's surface mode does not collapse, so this test shows nothing";
    EXPECT_LT(1 - bar.SmallestCrossSection(frame), 0.7 * (1 - bar.SmallestCrossSection(shell)))
        << turns;
    EXPECT_LT(MeanError(frame, half), 0.5 * MeanError(shell, half)) << turns;
  }
}

TEST(Volumetric, VolumeOfEachBodyFollowsTheKeys) {
  Mesh mesh = Bar(0.15).mesh, ball = MakeIcosphere(2);
  const int first_faces = mesh.face_count();
  ball.points *= 0.3;
  ball.points.rowwise() += Eigen::RowVector3d(1, 0, 1);
  const int v = mesh.vertex_count();
  PointsX3 u(v + ball.vertex_count(), 3);
  u.topRows(v) = 1.2 * Bar(0.15).Bent(3);
  u.bottomRows(ball.vertex_count()) = ball.points * Eigen::Vector3d(0.5, 1, 1).asDiagonal();
  Join(mesh, ball);
  const VolumetricInterpolator solid(mesh.points, u, mesh.faces);
  EXPECT_EQ(solid.report().bodies, 2);
  for (double t : {0.2, 0.5, 0.9}) {
    const PointsX3 frame = solid.At(t);
    for (const FacesX3& faces : {mesh.faces.topRows(first_faces).eval(),
                                 mesh.faces.bottomRows(ball.face_count()).eval()}) {
      const double v0 = SignedVolume(mesh.points, faces), v1 = SignedVolume(u, faces);
      EXPECT_NEAR(SignedVolume(frame, faces) / (std::pow(v0, 1 - t) * std::pow(v1, t)), 1, 1e-9);
    }
  }
}

TEST(Volumetric, HollowBodyKeepsItsWall) {
  const Mesh mesh = HollowBall();
  const PointsX3 u = mesh.points * Eigen::Vector3d(1, 1, 1.8).asDiagonal();
  const VolumetricInterpolator solid(mesh.points, u, mesh.faces);
  EXPECT_EQ(solid.report().bodies, 1);
  EXPECT_LT(Gap(solid.At(0.5), mesh.points * Eigen::Vector3d(1, 1, std::sqrt(1.8)).asDiagonal()),
            1e-6);  // exact but for the inner points' fit
}

TEST(Volumetric, VerticesWithoutFacesGoStraight) {
  Mesh mesh = MakeIcosphere(1);
  mesh.points.conservativeResize(mesh.vertex_count() + 1, 3);
  mesh.points.bottomRows(1) << 5, 0, 0;
  PointsX3 u = mesh.points;
  u.bottomRows(1) << 5, 2, 0;
  const PointsX3 frame = VolumetricInterpolator(mesh.points, u, mesh.faces).At(0.25);
  EXPECT_LT((frame.bottomRows(1) - Eigen::RowVector3d(5, 0.5, 0)).norm(), 1e-12);
}

TEST(Volumetric, FillsTheOtherKeyWhereTheSmootherOneCrossesItself) {
  const Bar bar(0.1);
  PointsX3 rough = bar.mesh.points;  // with bumps the straight key is the less smooth one
  for (Eigen::Index i = 0; i < rough.rows(); ++i)
    rough.row(i).head<2>() *= 1 + 0.2 * std::sin(40 * rough(i, 2));
  const PointsX3 crossing = bar.Bent(2.3 * kPi);
  const VolumetricInterpolator solid(crossing, rough, bar.mesh.faces);
  EXPECT_EQ(solid.report().meshed_key, 1);
  EXPECT_THAT(solid.report().note, testing::HasSubstr("passes through itself"));
  EXPECT_TRUE(solid.At(0.5).allFinite());
}

TEST(Volumetric, WhereBothKeysCrossThemselvesThePlacesArePartedToFillThem) {
  // Two intersecting spikes, in both keys; one key is rotated and slightly longer.
  const Bar bar(0.15);
  PointsX3 v = bar.mesh.points;
  const int a = 14 * Bar::kSegments, b = 17 * Bar::kSegments;
  v.row(a) += Eigen::RowVector3d(0.1, 0, 0.12);
  v.row(b) += Eigen::RowVector3d(0.1, 0.01, -0.12);
  PointsX3 u = v * Turn(1, Eigen::Vector3d::UnitX()).transpose();
  u.col(2) *= 1.1;
  const VolumetricInterpolator solid(v, u, bar.mesh.faces);
  EXPECT_GT(solid.report().parted, 0);
  EXPECT_THAT(solid.report().note, testing::HasSubstr("passes through itself"));
  EXPECT_LT(Gap(solid.At(1e-10), v), 1e-8);
  EXPECT_LT(Gap(solid.At(1 - 1e-10), u), 1e-8);
  const PointsX3 exact = v * Turn(0.5, Eigen::Vector3d::UnitX()).transpose() *
                         Eigen::Vector3d(1, 1, std::sqrt(1.1)).asDiagonal();
  EXPECT_LT(MeanError(solid.At(0.5), exact), 0.01);
}

TEST(Volumetric, WhatNoPartingHelpsThrows) {
  const Bar bar(0.1);
  EXPECT_THAT(MessageOf([&] {
                VolumetricInterpolator(bar.Bent(2.3 * kPi), bar.Bent(2.5 * kPi), bar.mesh.faces);
              }),
              testing::HasSubstr("nor can the"));
}

TEST(Volumetric, TetrahedraThatTheSurfaceTurnsInsideOutAreCountedAndTheEndsStayExact) {
  const Mesh mesh = MakeIcosphere(1);
  PointsX3 u = mesh.points;
  u.row(0) = -1.5 * u.row(0);  // a vertex pushed out of the far side
  const VolumetricInterpolator solid(mesh.points, u, mesh.faces);
  EXPECT_GT(solid.report().inverted, 0);
  EXPECT_LT(Gap(solid.At(1 - 1e-10), u), 1e-8);
  EXPECT_TRUE(solid.At(0.5).allFinite());
}

TEST(Volumetric, SameBitsAtOneAndTwoThreads) {
  const Bar bar(0.2, true);
  const PointsX3 u = bar.Twisted(7);
  std::vector<PointsX3> frames;
  for (int threads : {1, 2}) {
    SetThreadCount(threads);
    frames.push_back(VolumetricInterpolator(bar.mesh.points, u, bar.mesh.faces).At(0.3));
  }
  SetThreadCount(0);
  EXPECT_TRUE(SameBits(frames[0], frames[1]));
}

TEST(Volumetric, KeysOfOtherSizesAndMirroredKeysThrow) {
  const Mesh mesh = MakeIcosphere(1);
  EXPECT_THROW(VolumetricInterpolator(mesh.points, mesh.points.topRows(5), mesh.faces), InputError);
  EXPECT_THAT(MessageOf([&] { VolumetricInterpolator(mesh.points, -mesh.points, mesh.faces); }),
              testing::HasSubstr("inside out"));
}

}  // namespace
}  // namespace keypose::interpolation
