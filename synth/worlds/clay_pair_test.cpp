// Pairs for registration: the solution is exact, the two meshes share only the solid, and the
// damage is as requested.
#include "synth/worlds/clay_pair.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "synth/worlds/testing/pair_options.h"

namespace keypose::synth::clay_pair_test {

using Eigen::Vector3d;

constexpr double kPi = 3.141592653589793;

double SmallestAngleDeg(const Mesh& mesh) {
  double smallest = kPi;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = mesh.points.row(mesh.faces(f, k));
      const Vector3d u = mesh.points.row(mesh.faces(f, (k + 1) % 3)).transpose() - p;
      const Vector3d v = mesh.points.row(mesh.faces(f, (k + 2) % 3)).transpose() - p;
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
  return smallest * 180 / kPi;
}

int EulerNumber(const Mesh& mesh) {
  return mesh.vertex_count() - static_cast<int>(UndirectedEdges(mesh.faces).size()) +
         mesh.face_count();
}

TEST(ClayPair, MeshesAreClosedEvenAndOfTheAskedSize) {
  for (const char* shape : {"tentacle", "character"}) {
    ClayPairOptions options = Options(200, 3, shape);
    options.vertices = 1200;
    const ClayPair pair = MakeClayPair(options);
    for (const Mesh* mesh : {&pair.source, &pair.target}) {
      const ClosedReport report = CheckClosed(*mesh);
      EXPECT_TRUE(report.closed());
      EXPECT_EQ(report.components, 1);
      EXPECT_EQ(report.euler, 2);
      EXPECT_NEAR(mesh->vertex_count(), 1200, 0.05 * 1200);
      EXPECT_GT(SmallestAngleDeg(*mesh),
                18);  // 25 to 31 is usual; matters since registration uses cotangent weights
    }
  }
}

TEST(ClayPair, TruthOfTheTentacleIsAnArcOfTheAskedAngle) {
  const ClayPairOptions options = Options(270);
  const ClayPair pair = MakeClayPair(options);
  // Computed by hand: the axis runs from z = 6 mm to 200 mm and becomes three quarters of a circle;
  // a point keeps its distance to the axis.
  const double begin = 0.006, end = 0.2, radius = (end - begin) / (1.5 * kPi);
  const Vector3d side = Vector3d::UnitZ().unitOrthogonal(),
                 center = radius * side + begin * Vector3d::UnitZ();
  int on_limb = 0, on_body = 0;
  for (Eigen::Index i = 0; i < pair.truth.rows(); ++i) {
    const Vector3d rest = pair.source.points.row(i), posed = pair.truth.row(i);
    if (rest.z() <= begin) {
      ++on_body;
      ASSERT_LT((rest - posed).norm(), 1e-15);
      continue;
    }
    ++on_limb;
    const double turned = 1.5 * kPi * (rest.z() - begin) / (end - begin),
                 from_center = radius - rest.dot(side);
    const Vector3d expected =
        center + from_center * (-std::cos(turned) * side + std::sin(turned) * Vector3d::UnitZ()) +
        (rest - rest.dot(side) * side).cwiseProduct(Vector3d(1, 1, 0));
    ASSERT_LT((posed - expected).norm(), 1e-12) << "vertex " << i;
  }
  EXPECT_GT(on_limb, 200);
  EXPECT_GT(on_body, 100);
}

TEST(ClayPair, TargetVerticesLieOnThePosedSolidExactly) {
  for (const char* shape : {"tentacle", "character"}) {
    const ClayPairOptions options = Options(180, 2, shape);
    const ClayPair pair = MakeClayPair(options);
    const LimbedShape thing = MakeLimbedShape(options.shape);
    const KdTree tree(pair.truth);
    for (Eigen::Index i = 0; i < pair.target.points.rows(); ++i) {
      const Vector3d posed = pair.target.points.row(i);
      const Vector3d material =
          thing.pose.Inverse(posed, pair.source.points.row(tree.Nearest(posed).index));
      ASSERT_LT(std::abs(thing.clay.Distance(material)), 1e-8) << shape << " vertex " << i;
    }
  }
}

TEST(ClayPair, TessellationsShareNoVertices) {
  // no bend: only the lattices differ
  const ClayPair pair = MakeClayPair(Options(0, 1));
  const KdTree tree(pair.target.points);
  const double near = 0.05 * MeanEdge(pair.target);
  int coincide = 0;
  for (Eigen::Index i = 0; i < pair.truth.rows(); ++i)
    coincide += std::sqrt(tree.Nearest(Vector3d(pair.truth.row(i))).squared_distance) < near;
  // For random points this would happen in 0.9 % of the cases.
  EXPECT_LT(coincide, 0.03 * static_cast<double>(pair.truth.rows()));
}

TEST(ClayPair, SourceIsTheSameWhateverBecomesOfTheTarget) {
  const ClayPair plain = MakeClayPair(Options(60, 4));
  ClayPairOptions options = Options(240, 4);
  options.noise = 0.002;
  options.holes = 3;
  options.shape.places = 7;
  options.turn_deg = 90;
  const ClayPair other = MakeClayPair(options);
  EXPECT_EQ(plain.source.points, other.source.points);
  EXPECT_EQ(plain.source.faces, other.source.faces);
}

TEST(ClayPair, NoiseHasTheAskedDeviationOnEveryAxis) {
  ClayPairOptions options = Options(120, 5);
  options.vertices = 1500;
  const ClayPair clean = MakeClayPair(options);
  options.noise = 0.002;
  const ClayPair noisy = MakeClayPair(options);
  ASSERT_EQ(clean.target.faces, noisy.target.faces);
  EXPECT_EQ(clean.truth, noisy.truth);
  const PointsX3 moved = (noisy.target.points - clean.target.points) / clean.diagonal;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::sqrt(moved.col(k).squaredNorm() / static_cast<double>(moved.rows())), 0.002,
                0.002 * 0.08);  // 4 sigma of 1500
    EXPECT_NEAR(moved.col(k).mean(), 0, 0.002 * 0.11);
  }
}

TEST(ClayPair, HolesAreAsManyAndAsLargeAsAskedAndSpareTheLandmarks) {
  for (const auto& [count, share] : {std::pair(6, 0.02), std::pair(4, 0.1)}) {
    ClayPairOptions options = Options(150, 6);
    options.vertices = 2000;
    const ClayPair whole = MakeClayPair(options);
    options.holes = count;
    options.hole_area = share;
    const ClayPair holed = MakeClayPair(options);
    EXPECT_EQ(EulerNumber(holed.target), 2 - count);
    EXPECT_EQ(CheckClosed(holed.target).components, 1);
    const double area = SurfaceArea(whole.target.points, whole.target.faces);
    // Each hole is too large by less than the faces around one vertex.
    EXPECT_NEAR(1 - SurfaceArea(holed.target.points, holed.target.faces) / area, share,
                0.2 * share);
    for (std::size_t i = 0; i < holed.picks.size(); ++i)
      EXPECT_LT((PositionOf(holed.picks[i].target, holed.target) -
                 PositionOf(whole.picks[i].target, whole.target))
                    .norm(),
                1e-12);
  }
}

TEST(ClayPair, PicksAreTheTruePlacesWithinTheirNoise) {
  ClayPairOptions options = Options(180, 7);
  options.vertices = 1700;
  options.shape.places = 20;
  for (const double noise : {0.0, 0.004}) {
    options.landmark_noise = noise;
    const ClayPair pair = MakeClayPair(options);
    ASSERT_EQ(pair.picks.size(), 20u);
    std::set<std::string> names;
    double square = 0;
    for (const LandmarkPair& pick : pair.picks) {
      EXPECT_TRUE(names.insert(pick.name).second) << pick.name;
      int corner = 0;
      ASSERT_EQ(pick.source.barycentric.maxCoeff(&corner), 1);
      const Vector3d truth = pair.truth.row(pair.source.faces(pick.source.face, corner));
      square += (PositionOf(pick.target, pair.target) - truth).squaredNorm() /
                (pair.diagonal * pair.diagonal) / 20;
    }
    // Snapping to the surface removes the error along one of three axes; without noise only the
    // height of the chords remains.
    EXPECT_NEAR(std::sqrt(square), std::sqrt(2.0) * noise,
                noise == 0 ? 0.002 : 0.35 * std::sqrt(2.0) * noise);
  }
  options.shape.places = 0;
  EXPECT_TRUE(MakeClayPair(options).picks.empty());
}

TEST(ClayPair, FewLandmarksAreTheFirstOfMany) {
  for (const char* shape : {"tentacle", "character"}) {
    ClayPairOptions options = Options(90, 1, shape);
    const ClayPair many = MakeClayPair(options);
    options.shape.places = 7;
    const ClayPair few = MakeClayPair(options);
    EXPECT_EQ(few.target.points, many.target.points);
    ASSERT_EQ(few.picks.size(), 7u);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(few.picks[i].name, many.picks[i].name);
  }
}

TEST(ClayPair, TurnAndScaleMoveTheTargetAsAWhole) {
  const ClayPair plain = MakeClayPair(Options(90, 3));
  ClayPairOptions options = Options(90, 3);
  options.turn_deg = 137;
  options.scale = 25;
  const ClayPair moved = MakeClayPair(options);
  EXPECT_EQ(moved.source.points, plain.source.points);
  ASSERT_EQ(moved.truth.rows(), plain.truth.rows());
  const Eigen::Matrix4d map = Eigen::umeyama(Eigen::MatrixXd(plain.truth.transpose()),
                                             Eigen::MatrixXd(moved.truth.transpose()), true);
  const Eigen::Matrix3d linear = map.topLeftCorner<3, 3>();
  EXPECT_NEAR(std::cbrt(linear.determinant()), 25, 1e-9);
  EXPECT_NEAR(Eigen::AngleAxisd(Eigen::Matrix3d(linear / 25)).angle() * 180 / kPi, 137, 1e-6);
  for (const auto& [from, to] : {std::pair(&plain.truth, &moved.truth),
                                 std::pair(&plain.target.points, &moved.target.points)})
    EXPECT_LT(
        ((*from * linear.transpose()).rowwise() + map.topRightCorner<3, 1>().transpose() - *to)
            .rowwise()
            .norm()
            .maxCoeff(),
        1e-9);
}

TEST(ClayPair, RatioSetsTheTargetsFaces) {
  ClayPairOptions options = Options(90, 2);
  options.ratio = 8;
  const ClayPair pair = MakeClayPair(options);
  EXPECT_NEAR(pair.target.face_count() / static_cast<double>(pair.source.face_count()), 8, 0.6);
}

TEST(ClayPair, SquashKeepsTheVolumeOfTheTruth) {
  ClayPairOptions options = Options(0, 1);
  options.shape.squash = 0.7;
  const ClayPair pair = MakeClayPair(options);
  EXPECT_GT((pair.truth - pair.source.points).cwiseAbs().maxCoeff(), 0.02);
  const double volume = SignedVolume(pair.source.points, pair.source.faces);
  EXPECT_NEAR(SignedVolume(pair.truth, pair.source.faces) / volume, 1, 1e-12);
}

TEST(ClayPair, SameBitsAtOneAndManyThreads) {
  ClayPairOptions options = Options(200, 9);
  options.noise = 0.001;
  options.holes = 2;
  SetThreadCount(1);
  const ClayPair one = MakeClayPair(options);
  SetThreadCount(4);
  const ClayPair many = MakeClayPair(options);
  SetThreadCount(0);
  EXPECT_EQ(one.source.points, many.source.points);
  EXPECT_EQ(one.target.points, many.target.points);
  EXPECT_EQ(one.target.faces, many.target.faces);
  EXPECT_EQ(one.truth, many.truth);
  EXPECT_EQ(one.picks[3].target.barycentric, many.picks[3].target.barycentric);
}

TEST(ClayPair, OptionsOutOfRangeThrowUsageError) {
  const auto with = [](auto change) {
    ClayPairOptions options = Options(90);
    change(options);
    return options;
  };
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.shape.bend_deg = 300; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.shape.bend_deg = NAN; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.shape.shape = "teapot"; })),
               UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.shape.twist_deg = 1000; })),
               UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.shape.squash = 0; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.shape.places = -1; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.vertices = 10; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.ratio = 100; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.noise = -1; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.landmark_noise = NAN; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.holes = -1; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.hole_area = 0.9; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.turn_deg = NAN; })), UsageError);
  EXPECT_THROW(MakeClayPair(with([](ClayPairOptions& o) { o.scale = 0; })), UsageError);
}

}  // namespace keypose::synth::clay_pair_test
