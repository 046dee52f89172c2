// Soles that no photograph shows are cut flat if the figure stands on the ground, and stay
// unchanged if not.
#include "cleanup/support/ground.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "cleanup/repair/intersections.h"
#include "cleanup/strategies/cleanup.h"
#include "cleanup/testing/damaged_meshes.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/testing/shots.h"

namespace keypose::cleanup::ground_test {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCap = 0.06;  // about 0.4 tan(12 degrees), minus the effect of smoothing

/// A pawn that stands at z = 0, without or with a cap of the visual hull below its foot of radius
/// 0.4.
/// @param below  further rows of the profile
Mesh Pawn(const std::vector<Vector2d>& below) {
  std::vector<Vector2d> profile;
  for (int i = 1; i <= 6; ++i)
    profile.emplace_back(0.25 * std::sin(0.4 * i), 1.25 + 0.25 * std::cos(0.4 * i));
  for (int i = 0; i <= 8; ++i) profile.emplace_back(0.2 + 0.2 * i * i / 64.0, 1.0 - 0.1 * i);
  profile.emplace_back(0.4, 0.1);
  profile.emplace_back(0.4, 0);
  profile.insert(profile.end(), below.begin(), below.end());
  return MakeRevolved(profile, 64);
}
Mesh TruePawn() { return Pawn({{0.2, 0}}); }
Mesh WithCap() {
  return Pawn({{0.3, -0.25 * kCap}, {0.2, -0.5 * kCap}, {0.1, -0.75 * kCap}, {0.03, -kCap}});
}
/// The pawn with a thin rod below. The lower photographs show a third of the rod.
Mesh WithRod() { return Pawn({{0.2, 0}, {0.06, 0}, {0.05, -0.1}, {0.05, -0.24}}); }

MaskShot Photograph(const Mesh& mesh, const std::vector<double>& elevations_deg) {
  return MasksFromRings(mesh, {0, 0, 0.7}, elevations_deg, 10, 320);
}

/// Area of the faces that lie at z = 0.
double FlatArea(const Mesh& mesh) {
  double area = 0;
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  for (int f = 0; f < mesh.face_count(); ++f) {
    bool flat = true;
    for (int k = 0; k < 3; ++k) flat = flat && std::abs(mesh.points(mesh.faces(f, k), 2)) < 1e-9;
    if (flat) area += areas[f];
  }
  return area;
}

TEST(StandsOnGround, FigureOnItsFeetDoesAndWhatIsSeenBelowOrFarAwayDoesNot) {
  const MaskShot shot = Photograph(TruePawn(), {12, 40});
  EXPECT_TRUE(StandsOnGround(WithCap(), shot.views, shot.masks).stands);
  EXPECT_TRUE(StandsOnGround(TruePawn(), shot.views, shot.masks).stands);

  // The figure is held by a rig: the outlines end above z = 0.
  Mesh up = WithCap(), up_truth = TruePawn();
  up.points.col(2).array() += 0.08, up_truth.points.col(2).array() += 0.08;
  const MaskShot rig = Photograph(up_truth, {12, 40});
  EXPECT_FALSE(StandsOnGround(up, rig.views, rig.masks).stands);

  // Photographs show a rod below the ground, which is too thin to affect the ground's estimated
  // height.
  const MaskShot rod = Photograph(WithRod(), {12, 40});
  EXPECT_FALSE(StandsOnGround(WithRod(), rod.views, rod.masks).stands);

  // Also photographed from below, as when it lies on its back.
  const MaskShot lying = Photograph(TruePawn(), {12, 40, -30});
  EXPECT_FALSE(StandsOnGround(WithCap(), lying.views, lying.masks).stands);

  EXPECT_FALSE(StandsOnGround(WithCap(), {}, {}).stands);
}

TEST(StandsOnGround, NothingIsBelowABoard) {
  // Masks that are too large at the soles: the outlines end below z = 0 by 2 % of the height.
  Mesh mesh = WithCap(), seen = TruePawn();
  const double tall = seen.points.col(2).maxCoeff();
  mesh.points.col(2).array() -= 0.02 * tall, seen.points.col(2).array() -= 0.02 * tall;
  const MaskShot low = Photograph(seen, {12, 40});
  EXPECT_FALSE(StandsOnGround(mesh, low.views, low.masks).stands);
  EXPECT_TRUE(StandsOnGround(mesh, low.views, low.masks, GroundKind::kBoard).stands);
  // A board does not make it stand that is held above it.
  mesh.points.col(2).array() += 0.04 * tall, seen.points.col(2).array() += 0.04 * tall;
  const MaskShot high = Photograph(seen, {12, 40});
  EXPECT_FALSE(StandsOnGround(mesh, high.views, high.masks, GroundKind::kBoard).stands);
}

// The plane is known: outlines need not end there. A camera that looks up from below shows soles.
TEST(StandsOnGround, OnAKnownFloorUnlessCamerasLookUp) {
  Mesh mesh = WithCap(), seen = TruePawn();
  const double tall = seen.points.col(2).maxCoeff();
  mesh.points.col(2).array() -= 0.07 * tall, seen.points.col(2).array() -= 0.07 * tall;
  const MaskShot low = Photograph(seen, {12, 40});
  EXPECT_FALSE(StandsOnGround(mesh, low.views, low.masks, GroundKind::kBoard).stands);
  EXPECT_TRUE(StandsOnGround(mesh, low.views, low.masks, GroundKind::kFloor).stands);
  const MaskShot lying = Photograph(seen, {12, 40, -30});
  EXPECT_FALSE(StandsOnGround(mesh, lying.views, lying.masks, GroundKind::kFloor).stands);
}

TEST(MakeClosedManifold, SolesAreFlatAtTheGroundAndNothingLiesBelow) {
  CleanupOptions options;
  options.faces = 4000;
  const CleanupResult result = MakeClosedManifold(WithCap(), options, nullptr, {}, 0.0);
  EXPECT_TRUE(CheckClosed(result.mesh).closed());
  EXPECT_FALSE(SelfIntersects(result.mesh));
  EXPECT_EQ(result.mesh.points.col(2).minCoeff(), 0);
  const Mesh truth = TruePawn();
  const double sole = 64.0 / 2 * std::sin(2 * EIGEN_PI / 64) * 0.16;  // of a polygon of 64 corners
  EXPECT_NEAR(FlatArea(result.mesh), sole,
              0.08 * sole);  // the ring of faces at the edge need not lie flat
  EXPECT_NEAR(result.volume, SignedVolume(truth.points, truth.faces), 0.003 * result.volume);
  EXPECT_GT(result.cut_below_ground_over_diag, 0.02);
  const CleanupResult again = MakeClosedManifold(result.mesh, options, nullptr, {}, 0.0);
  EXPECT_EQ(again.strategy, "as-is");
  EXPECT_EQ(again.mesh.points, result.mesh.points);
  // Without the ground the cap stays.
  EXPECT_LT(MakeClosedManifold(WithCap(), options).mesh.points.col(2).minCoeff(), -0.9 * kCap);
}

TEST(CleanupProgram, FigureStandsOnTheGroundByItsPhotographs) {
  const TestingFolder own;
  const fs::path folder = own.path();
  WriteShot(folder, Photograph(TruePawn(), {12, 40}));
  WriteMesh(folder / "pawn.ply", WithCap());
  const std::string at = folder.string();
  const auto lowest = [&](const std::string& more) {
    const std::string command = BinFolder() + "/keypose-cleanup --surface " + at +
                                "/pawn.ply --images " + at + "/images --model " + at +
                                "/model --faces 4000 --clean " + at + "/clean.ply --report " + at +
                                "/report.json " + more + " > " + at + "/log 2>&1";
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 0) << ReadFile(folder / "log");
    return ReadMesh(folder / "clean.ply").points.col(2).minCoeff();
  };
  EXPECT_EQ(lowest(""), 0);
  EXPECT_NE(ReadFile(folder / "report.json").find("\"stands_on_ground\": true"), std::string::npos);
  EXPECT_LT(lowest("--ground keep"), -0.9 * kCap);
}

}  // namespace keypose::cleanup::ground_test
