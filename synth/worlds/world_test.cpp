#include "synth/worlds/world.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <set>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "synth/worlds/outer_surface.h"

namespace keypose::synth::world_test {

using Eigen::Vector3d;

WorldOptions Coarse(std::uint64_t seed, const std::string& texture = "rich") {
  WorldOptions options;
  options.seed = seed;
  options.spacing_m = 0.005;
  options.texture = texture;
  return options;
}

/// A coarse world that is made once and only read.
const World& Made(std::uint64_t seed) {
  static std::map<std::uint64_t, World> worlds;
  const auto found = worlds.find(seed);
  return found != worlds.end() ? found->second
                               : worlds.emplace(seed, MakeWorld(Coarse(seed))).first->second;
}

TEST(MakeWorld, EveryCharacterIsOneClosedBodyStandingOnTheTable) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const World& world = Made(seed);
    const ClosedReport report = CheckClosed(world.rest);
    EXPECT_TRUE(report.closed()) << "seed " << seed;
    EXPECT_EQ(report.components, 1) << "seed " << seed;
    EXPECT_NEAR(world.rest.points.col(2).minCoeff(), 0, 0.0005) << "seed " << seed;
    EXPECT_NEAR(world.rest.points.col(2).maxCoeff(), 0.21, 0.03) << "seed " << seed;
  }
}

TEST(MakeWorld, SurfaceHasTheSolidsVolume) {
  // Independent of the mesher: counts points of a fine grid inside the solid.
  const World& world = Made(1);
  Vector3d low, high;
  world.clay.Bounds(&low, &high);
  constexpr double kStep = 0.0025;
  double inside = 0;
  for (double z = low[2] + kStep / 2; z < high[2]; z += kStep)
    for (double y = low[1] + kStep / 2; y < high[1]; y += kStep)
      for (double x = low[0] + kStep / 2; x < high[0]; x += kStep)
        inside += world.clay.Distance({x, y, z}) < 0;
  const double volume = inside * kStep * kStep * kStep;
  EXPECT_NEAR(SignedVolume(world.rest.points, world.rest.faces) / volume, 1,
              0.01);  // chords of 2.5 mm on limbs of 10 mm
}

TEST(MakeWorld, CharacterHasNoMirrorTwin) {
  // The character and its mirror image must differ by far more than reconstruction errors;
  // otherwise left and right could be confused.
  const World& world = Made(1);
  double worst = 0;
  for (Eigen::Index i = 0; i < world.rest.points.rows(); i += 5) {
    Vector3d mirrored = world.rest.points.row(i);
    mirrored[0] = -mirrored[0];
    worst = std::max(worst, std::abs(world.clay.Distance(mirrored)));
  }
  EXPECT_GT(worst, 0.02);
}

TEST(MakeWorld, WeakTextureHasAnEighthOfTheGrain) {
  const World &rich = Made(1), weak = MakeWorld(Coarse(1, "weak"));
  const auto contrast = [](const World& world) {
    double sum = 0, squares = 0;
    constexpr int kCount = 4000;
    for (int i = 0; i < kCount; ++i) {  // along a line in the body's clay
      const double v = world.clay.Paint({0.00002 * i, 0.03, 0.07}, 0)[1];
      sum += v, squares += v * v;
    }
    const double mean = sum / kCount;
    return std::sqrt(squares / kCount - mean * mean) / mean;
  };
  EXPECT_GT(contrast(rich), 0.10);
  EXPECT_NEAR(contrast(weak) / contrast(rich), 0.12, 0.03);
}

TEST(MakeWorld, LandmarksAreDistinctPointsNearTheirFeature) {
  for (const std::uint64_t seed : {1, 4}) {
    const World& world = Made(seed);
    std::set<int> vertices;
    std::set<std::string> names;
    for (const TruthLandmark& landmark : world.landmarks) {
      vertices.insert(landmark.vertex);
      names.insert(landmark.name);
    }
    EXPECT_GE(world.landmarks.size(), 16u);
    EXPECT_EQ(vertices.size(), world.landmarks.size());
    EXPECT_EQ(names.size(), world.landmarks.size());
    const PointsX3 places = LandmarkPositions(world, world.PoseNamed("rest"));
    for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
      if (world.landmarks[i].name == "left_finger") {
        EXPECT_GT(places(static_cast<Eigen::Index>(i), 0), 0.09);
      }
      if (world.landmarks[i].name == "nose") {
        EXPECT_LT(places(static_cast<Eigen::Index>(i), 1), -0.06);
      }
    }
  }
}

TEST(MakeWorld, SameBitsAtOneAndManyThreads) {
  SetThreadCount(1);
  const World one = MakeWorld(Coarse(2));
  const Mesh colored = TruthSurface(one, one.poses[1], true);
  SetThreadCount(4);
  const World many = MakeWorld(Coarse(2));
  EXPECT_EQ(one.rest.points, many.rest.points);
  EXPECT_EQ(colored.colors, TruthSurface(many, many.poses[1], true).colors);
  SetThreadCount(0);
}

TEST(MakeWorld, HandOnHipClosesAHandleThatTheMaterialSurfaceLacks) {
  for (const std::uint64_t seed : {1, 4, 6}) {
    const World& world = Made(seed);
    const Pose& hip = world.PoseNamed("hip");
    const Mesh seen = SeenSurface(world, hip);
    EXPECT_TRUE(CheckClosed(seen).closed()) << "seed " << seed;
    EXPECT_EQ(CheckClosed(seen).components, 1) << "seed " << seed;
    EXPECT_EQ(Genus(seen), 1) << "seed " << seed;
    // A lattice this coarse leaves pinholes beside the eyes; the map of a pose adds none.
    EXPECT_EQ(Genus(TruthSurface(world, hip)), Genus(world.rest)) << "seed " << seed;
    EXPECT_EQ(Genus(SeenSurface(world, world.PoseNamed("wave"))), Genus(world.rest))
        << "seed " << seed;
  }
}

TEST(MakeWorld, HandOnHipLeavesAWindowThatAPhotographShows) {
  // A line of sight from the front through the arm's loop: free in the hip pose, with the arm on
  // three sides of it.
  const World& world = Made(1);
  const Mesh seen = SeenSurface(world, world.PoseNamed("hip"));
  const RayScene scene(seen.points, seen.faces);
  const auto blocked = [&](double x, double z) {
    return scene.Occluded({x, -1, z}, {0, 1, 0}, 0, 2);
  };
  int open = 0, row = 0;
  for (double x = -0.075; x < -0.030; x += 0.001) {
    const bool sees = !blocked(x, 0.068);
    row = sees ? row + 1 : 0;
    if (blocked(x - row * 0.001, 0.068)) open = std::max(open, row);  // closed on the arm's side
  }
  EXPECT_GE(open, 6);  // [mm] wide: 11 pixels of a photograph of 640 x 480
}

TEST(MakeWorld, ColumnsHaveThreeHandlesInEveryPose) {
  for (const std::uint64_t seed : {1, 2, 5}) {
    WorldOptions options = Coarse(seed);
    options.character = "columns";
    const World world = MakeWorld(options);
    EXPECT_TRUE(CheckClosed(world.rest).closed()) << "seed " << seed;
    EXPECT_EQ(CheckClosed(world.rest).components, 1) << "seed " << seed;
    for (const Pose& pose : world.poses) {
      EXPECT_EQ(Genus(SeenSurface(world, pose)), 3) << "seed " << seed << " " << pose.name;
      for (Eigen::Index i = 0; i < world.rest.points.rows(); i += 7)
        ASSERT_GT(pose.Jacobian(world.rest.points.row(i)).determinant(), 0.15)
            << "seed " << seed << " " << pose.name << " vertex " << i;
    }
  }
}

TEST(MakeWorld, BadOptionsThrow) {
  WorldOptions options;
  options.character = "horse";
  EXPECT_THROW(MakeWorld(options), UsageError);
  options = {};
  options.texture = "shiny";
  EXPECT_THROW(MakeWorld(options), UsageError);
  options = {};
  options.spacing_m = 0.1;
  EXPECT_THROW(MakeWorld(options), InputError);
  EXPECT_THROW(Made(1).PoseNamed("jump"), UsageError);
}

TEST(TruthSurface, VertexOfAPoseIsTheMappedMaterialPoint) {
  const World& world = Made(1);
  const Pose& bent = world.PoseNamed("bent");
  const Mesh surface = TruthSurface(world, bent);
  EXPECT_EQ(surface.faces, world.rest.faces);
  for (Eigen::Index i = 0; i < surface.points.rows(); i += 13)
    ASSERT_EQ(Vector3d(surface.points.row(i)), bent(Vector3d(world.rest.points.row(i))));
}

TEST(TruthSurface, PosesStayClosedAndRaiseTheArm) {
  const World& world = Made(1);
  int finger = -1;
  for (std::size_t i = 0; i < world.landmarks.size(); ++i)
    if (world.landmarks[i].name == "left_finger") finger = static_cast<int>(i);
  ASSERT_GE(finger, 0);
  const double rest_height = LandmarkPositions(world, world.PoseNamed("rest"))(finger, 2);
  EXPECT_GT(LandmarkPositions(world, world.PoseNamed("bent"))(finger, 2), rest_height + 0.03);
  for (const Pose& pose : world.poses)
    EXPECT_TRUE(CheckClosed(TruthSurface(world, pose)).closed()) << pose.name;
}

}  // namespace keypose::synth::world_test
