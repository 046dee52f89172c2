// Interpolation of bodies with known motion: bends and twists of several turns, swapped keys,
// volumes, loose parts.
#include "interpolate/surface/arap.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "deform/volume/volume_correction.h"

namespace keypose::interpolation::arap_test {

constexpr double kPi = std::numbers::pi;
constexpr double kLength = 2;

/// A body along z, 0 to kLength, bent to an arc of constant curvature in the xz plane.
PointsX3 Bent(const PointsX3& points, double degrees) {
  PointsX3 bent = points;
  const double radius = kLength / (degrees * kPi / 180);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = points(i, 2) / radius, r = radius - points(i, 0);
    bent.row(i) << radius - r * std::cos(a), points(i, 1), r * std::sin(a);
  }
  return bent;
}

PointsX3 Twisted(const PointsX3& points, double degrees) {
  PointsX3 twisted = points;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = points(i, 2) / kLength * degrees * kPi / 180;
    twisted.row(i) << std::cos(a) * points(i, 0) - std::sin(a) * points(i, 1),
        std::sin(a) * points(i, 0) + std::cos(a) * points(i, 1), points(i, 2);
  }
  return twisted;
}

/// A bar of square section, as long as MakeCylinder's tube; 4 * n segments round it.
Mesh MakeBar(double half_width, int n, int rings) {
  Mesh mesh = MakeCylinder(half_width, kLength, 4 * n, rings);
  for (Eigen::Index i = 0; i < mesh.points.rows() - 2; ++i) {
    const int k = static_cast<int>(i) % (4 * n);
    const double f = half_width * (2.0 * (k % n) / n - 1), w = half_width;
    const double corner[4][2] = {{w, f}, {-f, w}, {-w, -f}, {f, -w}};
    mesh.points(i, 0) = corner[k / n][0];
    mesh.points(i, 1) = corner[k / n][1];
  }
  return mesh;
}

/// Mean distance of vertices after the best rigid motion, over the diagonal.
double MeanGap(const PointsX3& frame, const PointsX3& truth) {
  return (Transformed(FitSimilarity(frame, truth, {}, false), frame) - truth)
             .rowwise()
             .norm()
             .mean() /
         BoundingDiagonal(truth);
}

double OffPath(double start, double middle, double end) {
  return std::abs(middle / std::sqrt(start * end) - 1);
}

struct Case {
  const char* name;
  bool twist;
  double degrees, radius;
  double mean_gap, area;  // allowed: about twice what was measured
};

class KnownWay : public ::testing::TestWithParam<Case> {};

TEST_P(KnownWay, MidwayIsHalfTheAngleWithItsAreaAndVolume) {
  const Case& c = GetParam();
  const Mesh mesh = MakeCylinder(c.radius, kLength, 16, 80);
  const auto pose = [&](double degrees) {
    return c.twist ? Twisted(mesh.points, degrees) : Bent(mesh.points, degrees);
  };
  const PointsX3 end = pose(c.degrees), truth = pose(0.5 * c.degrees);
  const ArapInterpolator arap(mesh.points, end, mesh.faces);
  EXPECT_FALSE(arap.report().turns.differential);
  EXPECT_EQ(arap.report().turns.torn_edges, 0);
  const PointsX3 middle = arap.At(0.5);
  EXPECT_LT(MeanGap(middle, truth), c.mean_gap);
  EXPECT_LT(OffPath(SurfaceArea(mesh.points, mesh.faces), SurfaceArea(middle, mesh.faces),
                    SurfaceArea(end, mesh.faces)),
            c.area);
  EXPECT_LT(OffPath(SignedVolume(mesh.points, mesh.faces), SignedVolume(middle, mesh.faces),
                    SignedVolume(end, mesh.faces)),
            1e-10);
  // The largest turn is that of the far end, less half a ring of faces and the turn of the held
  // end's region.
  EXPECT_NEAR(arap.largest_turn(), c.degrees * kPi / 180, 0.35);
}

// For comparison, at 150 degrees: bend 0.065 linear, 0.023 by Liu 2011; twist 0.024 linear, 0.0089
// by Liu, 0.0025 by shell geodesics.
INSTANTIATE_TEST_SUITE_P(Bodies, KnownWay,
                         ::testing::Values(Case{"Bend150", false, 150, 0.12, 2e-5, 2e-5},
                                         Case{"Bend270", false, 270, 0.12, 6e-5, 2e-4},
                                         Case{"Bend300", false, 300, 0.12, 1e-4, 2e-4},
                                         Case{"Bend450", false, 450, 0.05, 6e-5, 1e-4},
                                         Case{"Bend720", false, 720, 0.05, 3e-4, 2e-4},
                                         Case{"Bend1000", false, 1000, 0.05, 6e-4, 4e-4},
                                         Case{"Twist150", true, 150, 0.12, 1e-4, 2e-4},
                                         Case{"Twist270", true, 270, 0.05, 1e-4, 2e-4},
                                         Case{"Twist300", true, 300, 0.12, 5e-4, 1e-3},
                                         Case{"Twist450", true, 450, 0.05, 4e-4, 1e-3},
                                         Case{"Twist720", true, 720, 0.05, 8e-4, 3e-3},
                                         Case{"Twist1000", true, 1000, 0.05, 2e-3, 4e-3}),
                         [](const auto& i) { return i.param.name; });

TEST(Arap, SquareBarTwistedBy150DegreesIsCloserThanShellGeodesics) {
  const Mesh mesh = MakeBar(0.15, 6, 60);
  const PointsX3 end = Twisted(mesh.points, 150), truth = Twisted(mesh.points, 75);
  const ArapInterpolator arap(mesh.points, end, mesh.faces);
  EXPECT_LT(MeanGap(arap.At(0.5), truth), 1e-3);
  EXPECT_GT(MeanGap(InterpolateLinearly(mesh.points, end, 0.5), truth), 0.015);
}

TEST(Arap, SwapReversesTimeOnALongBendWithVolumeCorrection) {
  const Mesh mesh = MakeCylinder(0.12, kLength, 12, 40);
  PointsX3 end = Bent(mesh.points, 300) * 1.2;
  end.col(1) *= 1.3;
  const ArapInterpolator there(mesh.points, end, mesh.faces), back(end, mesh.points, mesh.faces);
  for (double t : {0.1, 0.25, 0.5, 0.8}) {
    const double gap =
        (there.At(t) - back.At(1 - t)).rowwise().norm().maxCoeff() / BoundingDiagonal(end);
    EXPECT_LT(gap, 1e-12) << t;
  }
  EXPECT_EQ(there.At(0), mesh.points);
  EXPECT_EQ(there.At(1), end);
  EXPECT_EQ(back.At(0), end);
}

TEST(Arap, TurnedAndMovedSecondKeyGivesNearlyTheSameShapes) {
  const Mesh mesh = MakeCylinder(0.12, kLength, 12, 40);
  const PointsX3 end = Bent(mesh.points, 200);
  Similarity3 motion;
  motion.rotation =
      Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  motion.translation << 4, -1, 2;
  const ArapInterpolator plain(mesh.points, end, mesh.faces),
      moved(mesh.points, Transformed(motion, end), mesh.faces);
  for (double t : {0.3, 0.5})
    EXPECT_LT(MeanGap(moved.At(t), plain.At(t)), 1e-5);  // another root of the turns
}

TEST(Arap, UniformGrowthWithATurnIsGeometric) {
  const Mesh mesh = MakeBar(0.3, 3, 12);
  Similarity3 motion;
  motion.rotation =
      Eigen::AngleAxisd(1.0, Eigen::Vector3d(0, 1, 1).normalized()).toRotationMatrix();
  motion.scale = 2;
  const PointsX3 frame =
      ArapInterpolator(mesh.points, Transformed(motion, mesh.points), mesh.faces).At(0.25);
  const double scale = std::pow(2, 0.25);
  for (const auto& [i, j] : UndirectedEdges(mesh.faces))
    EXPECT_NEAR((frame.row(i) - frame.row(j)).norm(),
                scale * (mesh.points.row(i) - mesh.points.row(j)).norm(), 1e-10);
}

Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  both.points.conservativeResize(a.points.rows() + b.points.rows(), 3);
  both.points.bottomRows(b.points.rows()) = b.points;
  both.faces.conservativeResize(a.faces.rows() + b.faces.rows(), 3);
  both.faces.bottomRows(b.faces.rows()) = b.faces.array() + a.vertex_count();
  return both;
}

TEST(Arap, EachClosedPartKeepsItsOwnVolumePath) {
  Mesh ball = MakeIcosphere(2);
  ball.points = (0.3 * ball.points).rowwise() + Eigen::RowVector3d(1, 0, 0);
  const Mesh mesh = Joined(MakeCylinder(0.2, kLength, 12, 20), ball);
  PointsX3 end = Bent(mesh.points, 150);
  const Eigen::Index n = ball.points.rows();
  end.bottomRows(n) = (1.5 * ball.points).rowwise() + Eigen::RowVector3d(0, 0.5, 0);
  const ArapInterpolator arap(mesh.points, end, mesh.faces);
  EXPECT_EQ(arap.report().closed_parts, 2);
  EXPECT_EQ(arap.report().corrected_parts, 2);
  const VolumeCorrection volumes(arap.system());
  const std::vector<double> v0 = volumes.Volumes(mesh.points), v1 = volumes.Volumes(end);
  std::vector<FrameFacts> facts;
  const std::vector<PointsX3> frames = arap.At({0.3, 0.7}, &facts);
  for (int k = 0; k < 2; ++k) {
    const std::vector<double> v = volumes.Volumes(frames[k]),
                              path = PathVolumes(v0, v1, k == 0 ? 0.3 : 0.7);
    for (int p = 0; p < 2; ++p) EXPECT_NEAR(v[p] / path[p], 1, 1e-12);
    EXPECT_GT(facts[k].volume_move, 0);
    EXPECT_LT(facts[k].volume_move, 1e-2);
  }
}

TEST(Arap, LoosePartKeepsItsPlaceOnTheLimbThatItSitsOn) {
  // An eyeball at the tip of a tube that bends by 300 degrees: half-way its centroid keeps its
  // place relative to the tip.
  Mesh ball = MakeIcosphere(1);
  const Eigen::RowVector3d place(0.1, 0, 1.9);
  ball.points = (0.06 * ball.points).rowwise() + place;
  const Mesh tube = MakeCylinder(0.1, kLength, 16, 80), mesh = Joined(tube, ball);
  const Eigen::Index n = tube.points.rows(), m = ball.points.rows();
  const ArapInterpolator arap(mesh.points, Bent(mesh.points, 300), mesh.faces);
  EXPECT_EQ(arap.report().riding_parts, 1);
  PointsX3 truth = Bent(mesh.points, 150), frame = arap.At(0.5);
  frame = Transformed(FitSimilarity(frame.topRows(n), truth.topRows(n), {}, false), frame);
  EXPECT_LT((frame.bottomRows(m).colwise().mean() - truth.bottomRows(m).colwise().mean()).norm(),
            0.01);
}

TEST(Arap, OpenMeshesAndTurnedOutPartsAreLeftAlone) {
  Mesh open = MakeCylinder(0.2, kLength, 12, 20);
  open.faces.conservativeResize(open.faces.rows() - 5, 3);
  const ArapInterpolator arap(open.points, Bent(open.points, 100), open.faces);
  EXPECT_EQ(arap.report().closed_parts, 0);
  EXPECT_EQ(arap.report().corrected_parts, 0);
  std::vector<FrameFacts> facts;
  EXPECT_TRUE(arap.At({0.5}, &facts)[0].allFinite());
  EXPECT_EQ(facts[0].volume_move, 0);
}

TEST(Arap, SameBitsForAnyThreadCountAndBatch) {
  const Mesh mesh = MakeCylinder(0.12, kLength, 16, 60);
  const PointsX3 end = Twisted(Bent(mesh.points, 200), 120);
  const std::vector<double> times = {0.1, 0.2, 0.3, 0.4, 0.5};
  SetThreadCount(1);
  const std::vector<PointsX3> one = ArapInterpolator(mesh.points, end, mesh.faces).At(times);
  SetThreadCount(2);
  const std::vector<PointsX3> two = ArapInterpolator(mesh.points, end, mesh.faces).At(times);
  SetThreadCount(0);
  for (std::size_t k = 0; k < times.size(); ++k) EXPECT_EQ(one[k], two[k]);
}

TEST(Arap, EndsAreMetByTheFormulaTooNotOnlyByCopies) {
  // Frames next to the keys are close to them: the copies at 0 and 1 hide no jump.
  const Mesh mesh = MakeCylinder(0.12, kLength, 12, 40);
  const PointsX3 end = Bent(mesh.points, 300);
  const ArapInterpolator arap(mesh.points, end, mesh.faces);
  const double speed = (end - mesh.points).rowwise().norm().maxCoeff();
  EXPECT_LT((arap.At(1e-9) - mesh.points).rowwise().norm().maxCoeff(), 1e-7 * speed);
  EXPECT_LT((arap.At(1 - 1e-9) - end).rowwise().norm().maxCoeff(), 1e-7 * speed);
}

}  // namespace keypose::interpolation::arap_test
