#include "register/skeleton/skeleton_start.h"
#include "core/testing/paths.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/io/meshes/mesh_io.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "register/skeleton/ray_patience.h"

namespace keypose::registration::skeleton_test {

using Eigen::RowVector3d;
using Eigen::Vector3d;

constexpr double kLength = 2.6, kNeck = 0.6, kThin = 0.1, kThick = 0.3, kDrift = 0.07;

/// A bulb with a straight tentacle along z.
Mesh Tentacle(int segments, int rings) {
  Mesh mesh = MakeCylinder(1, kLength, segments, rings);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double z = mesh.points(v, 2), u = std::clamp((z - 0.3) / 0.3, -1.0, 1.0);
    const double bulb = kThick * std::sqrt(std::max(0.0, 1 - u * u)),
                 tip = std::sqrt(std::clamp((kLength - z) / kThin, 0.0, 1.0));
    const double r = std::max(bulb, (z > 0.3 ? kThin : 0.02) * tip) + 1e-3;
    // The ends are round, not needles. The bulb is a little wider in one direction, so that its
    // rotation is visible.
    mesh.points(v, 0) *= r * (1 + 0.1 * bulb);
    mesh.points(v, 1) *= r;
  }
  return mesh;
}

/// Bends the tentacle beyond the neck by `angle` in the xz plane. It drifts along y, so that it
/// never meets itself. Cross-sections turn against the torsion of the helix, so that it bends
/// without twist.
PointsX3 Bent(const PointsX3& points, double angle) {
  PointsX3 bent = points;
  const double radius = (kLength - kNeck) / std::max(angle, 1e-9);
  for (Eigen::Index v = 0; v < bent.rows(); ++v) {
    const double along = points(v, 2) - kNeck;
    if (along <= 0) continue;
    const double a = along / radius, back = -kDrift / std::hypot(radius, kDrift) * a;
    const double x = std::cos(back) * points(v, 0) - std::sin(back) * points(v, 1),
                 y = std::sin(back) * points(v, 0) + std::cos(back) * points(v, 1);
    bent.row(v) << radius - (radius - x) * std::cos(a), y + kDrift * a,
        kNeck + (radius - x) * std::sin(a);
  }
  return bent;
}

struct Pair {
  Mesh source = Tentacle(24, 90), target = Tentacle(20, 110);
  PointsX3 truth;
  explicit Pair(double angle) : truth(Bent(source.points, angle)) {
    target.points = Bent(target.points, angle);
  }
  LandmarkGoal Mark(double x, double y, double z) const {
    int best = 0;
    (source.points.rowwise() - RowVector3d(x, y, z)).rowwise().squaredNorm().minCoeff(&best);
    LandmarkGoal goal;
    goal.source.vertices.setConstant(best);
    goal.target = truth.row(best);
    return goal;
  }
  double MeanError(const SkeletonStart& start) const {
    if (!start.usable()) return 1;
    return (start.points - truth).rowwise().norm().mean() / BoundingDiagonal(target.points);
  }
};

TEST(StartFromSkeletons, FollowsCurlsBeyondAFullTurnWithFewLandmarksOrNone) {
  for (double degrees : {60.0, 180.0, 270.0, 450.0}) {
    const Pair pair(degrees * M_PI / 180);
    const std::vector<LandmarkGoal> two = {pair.Mark(0, 0, kLength), pair.Mark(kThick, 0, 0.3)};
    for (const std::vector<LandmarkGoal>& marks :
         {std::vector<LandmarkGoal>{}, std::vector<LandmarkGoal>{two[0]}, two}) {
      const SkeletonStart start = StartFromSkeletons(pair.source, pair.target, marks);
      EXPECT_LT(pair.MeanError(start), 0.03)
          << degrees << " degrees, " << marks.size() << " landmarks: " << start.words;
      EXPECT_EQ(start.branches, 1);
      RecordProperty(std::to_string(static_cast<int>(degrees)) + "_" + std::to_string(marks.size()),
                     std::to_string(pair.MeanError(start)));
    }
  }
}

TEST(StartFromSkeletons, LandmarksOffTheAxisGiveTheTwist) {
  const Pair straight(0.0);
  Pair twisted(0.0);
  const double turn = 1.5;
  const auto twist = [&](PointsX3& points) {
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
      const double share = std::clamp((points(v, 2) - kNeck) / (kLength - kNeck), 0.0, 1.0);
      points.row(v) =
          (Eigen::AngleAxisd(turn * share, Vector3d::UnitZ()) * points.row(v).transpose().eval())
              .transpose();
    }
  };
  twist(twisted.truth);
  twist(twisted.target.points);
  const std::vector<LandmarkGoal> marks = {twisted.Mark(kThin, 0, 1.3), twisted.Mark(kThin, 0, 1.9),
                                           twisted.Mark(kThin, 0, 2.4)};
  const SkeletonStart with = StartFromSkeletons(twisted.source, twisted.target, marks),
                      without = StartFromSkeletons(twisted.source, twisted.target, {});
  EXPECT_LT(twisted.MeanError(with), 0.5 * twisted.MeanError(without));
  EXPECT_LT(twisted.MeanError(with), 0.01);
}

TEST(StartFromSkeletons, TheCoarseAlignmentTurnsTheRoot) {
  Pair pair(2.0);
  Similarity3 motion;
  motion.rotation = Eigen::AngleAxisd(2.2, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  motion.translation = Vector3d(4, 5, 6);
  motion.scale = 3;
  pair.target.points = Transformed(motion, pair.target.points);
  pair.truth = Transformed(motion, pair.truth);
  EXPECT_LT(pair.MeanError(StartFromSkeletons(pair.source, pair.target, {}, motion)), 0.03);
}

TEST(StartFromSkeletons, HolesInTheTargetAndLoosePartsDoNotStopIt) {
  Pair pair(3.0);
  std::vector<int> kept;
  for (int f = 0; f < pair.target.face_count(); ++f)
    if (f % 500 > 6) kept.push_back(f);
  FacesX3 faces(std::ssize(kept), 3);
  for (std::size_t i = 0; i < kept.size(); ++i) faces.row(i) = pair.target.faces.row(kept[i]);
  pair.target.faces = faces;
  const Mesh eye = MakeIcosphere(1);
  const int host = pair.source.vertex_count(), host_faces = pair.source.face_count();
  const PointsX3 ball = (0.05 * eye.points).rowwise() + RowVector3d(0, kThick, 0.3);
  const auto append = [&](PointsX3& points) {
    points.conservativeResize(host + eye.vertex_count(), 3);
    points.bottomRows(eye.vertex_count()) = ball;
  };
  append(pair.source.points);
  append(pair.truth);
  pair.source.faces.conservativeResize(host_faces + eye.face_count(), 3);
  pair.source.faces.bottomRows(eye.face_count()) = (eye.faces.array() + host).matrix();
  EXPECT_LT(pair.MeanError(StartFromSkeletons(pair.source, pair.target, {})), 0.03);
}

TEST(StartFromSkeletons, RefusesWhatHasNoTreeOfLimbsAndSaysWhy) {
  const Pair pair(1.0);
  Mesh ring;  // a torus
  const int around = 40, across = 16;
  ring.points.resize(around * across, 3);
  ring.faces.resize(2 * around * across, 3);
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * M_PI * i / around, b = 2 * M_PI * j / across, r = 1 + 0.2 * std::cos(b);
      ring.points.row(i * across + j) << r * std::cos(a), r * std::sin(a), 0.2 * std::sin(b);
      const int p = i * across + j, q = i * across + (j + 1) % across,
                s = (i + 1) % around * across + j, t = (i + 1) % around * across + (j + 1) % across;
      ring.faces.row(2 * p) << p, s, t;
      ring.faces.row(2 * p + 1) << p, t, q;
    }
  const SkeletonStart torus = StartFromSkeletons(ring, pair.target, {});
  EXPECT_FALSE(torus.usable());
  EXPECT_NE(torus.words.find("the source has 1 handles"), std::string::npos) << torus.words;
  Mesh two;
  two.points.resize(2 * ring.vertex_count(), 3);
  two.points << ring.points, ring.points.rowwise() + RowVector3d(5, 0, 0);
  two.faces.resize(2 * ring.face_count(), 3);
  two.faces << ring.faces, (ring.faces.array() + ring.vertex_count()).matrix();
  EXPECT_NE(StartFromSkeletons(pair.source, two, {}).words.find("the target has 2 separate parts"),
            std::string::npos);
  Mesh fan = MakeIcosphere(2);  // three faces on one edge
  fan.points.conservativeResize(fan.vertex_count() + 1, 3);
  fan.points.bottomRows(1) << 2, 2, 2;
  fan.faces.conservativeResize(fan.face_count() + 1, 3);
  fan.faces.bottomRows(1) << fan.faces(0, 0), fan.faces(0, 1), fan.vertex_count() - 1;
  EXPECT_NE(StartFromSkeletons(fan, pair.target, {}).words.find("not a manifold"),
            std::string::npos);
  EXPECT_THROW(StartFromSkeletons(Mesh(), pair.target, {}), InputError);
}

TEST(StartFromSkeletons, AShapelessLumpGivesNoNan) {
  const Mesh sphere = MakeIcosphere(3), box = MakeBox(1, 2, 3);
  for (const Mesh* target : {&sphere, &box}) {
    const SkeletonStart start = StartFromSkeletons(sphere, *target, {});
    EXPECT_TRUE(!start.usable() || start.points.allFinite());
    EXPECT_FALSE(start.words.empty());
  }
}

TEST(StartFromSkeletons, ShapesWithHardlyAnyVolumeAreRefused) {
  const Pair pair(1.0);
  Mesh flat = pair.target, line = pair.target;
  flat.points.col(1) *= 1e-8;
  line.points.leftCols(2) *= 1e-5;
  EXPECT_NE(StartFromSkeletons(pair.source, flat, {}).words.find("the target is flat"),
            std::string::npos);
  EXPECT_NE(StartFromSkeletons(flat, pair.target, {}).words.find("the source is flat"),
            std::string::npos);
  EXPECT_NE(StartFromSkeletons(pair.source, line, {}).words.find("the target is flat"),
            std::string::npos);
}

TEST(RayPatience, EndsAfterAHundredRaysThatToldNothing) {
  RayPatience patience;
  for (int point = 0; point < 2; ++point) {
    patience.Cast(true);
    for (int ray = 0; ray < 100; ++ray) patience.Cast(false);
  }
  EXPECT_THROW(patience.Cast(false), std::runtime_error);
}

TEST(StartFromSkeletons, StopsWhenAsked) {
  struct Stopped final : Progress {
    void Update(double, std::string_view) override {}
    bool cancelled() const override { return true; }
  } stopped;
  const Pair pair(1.0);
  EXPECT_THROW(StartFromSkeletons(pair.source, pair.target, {}, {}, {}, &stopped), Cancelled);
}

TEST(StartFromSkeletons, SameBitsAtAnyThreadCountAndAnyState) {
  const Pair pair(3.5);
  SetThreadCount(1);
  const PointsX3 first = StartFromSkeletons(pair.source, pair.target, {}).points;
  SetThreadCount(3);
  // A different heap: earlier allocations must not change the contraction.
  std::vector<std::vector<double>> clutter;
  for (int i = 0; i < 1000; ++i) clutter.emplace_back(static_cast<std::size_t>(i * 7 % 300 + 1));
  for (std::size_t i = 0; i < clutter.size(); i += 2) clutter[i] = {};
  const PointsX3 second = StartFromSkeletons(pair.source, pair.target, {}).points;
  SetThreadCount(0);
  ASSERT_GT(first.rows(), 0);
  EXPECT_EQ(first, second);
}

TEST(StartFromSkeletons, FourLimbsOfRealMeshesMapToTheirCounterparts) {
  const std::filesystem::path pairs = DataFolder() / "pairs";
  if (!std::filesystem::exists(pairs)) GTEST_SKIP() << "no data at " << pairs;
  const auto read = [&](const std::filesystem::path& path) {
    std::ifstream in(path);
    std::vector<std::pair<int, int>> rows;
    for (int a = 0, b = 0; in >> a >> b;) rows.emplace_back(a, b);
    return rows;
  };
  for (const char* name : {"faust_000_008", "lps_faust8k_000_018"}) {
    const Mesh source = ReadMesh(pairs / name / "source.obj"),
               target = ReadMesh(pairs / name / "target.obj");
    std::vector<LandmarkGoal> goals;
    for (const auto& [a, b] : read(pairs / name / "landmarks.txt")) {
      if (goals.size() == 12) break;
      LandmarkGoal goal;
      goal.source.vertices.setConstant(a);
      goal.target = target.points.row(b);
      goals.push_back(goal);
    }
    const SkeletonStart start = StartFromSkeletons(source, target, goals);
    ASSERT_TRUE(start.usable()) << start.words;
    double sum = 0, count = 0;
    for (const auto& [a, b] : read(pairs / name / "gt.txt")) {
      sum += (start.points.row(a) - target.points.row(b)).norm() / BoundingDiagonal(target.points);
      ++count;
    }
    EXPECT_LT(sum / count, 0.05) << name << ": " << start.words;
  }
}

}  // namespace keypose::registration::skeleton_test
