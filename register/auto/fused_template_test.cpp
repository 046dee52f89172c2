// A template whose parts touch in one shape and not in the other: a ring and a horseshoe.
#include "register/auto/fused_template.h"
#include "core/testing/paths.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"

namespace keypose::registration::topology_test {

namespace fs = std::filesystem;

/// A tube bent around z by `turn_deg`. It is thicker in the middle, so that the ends can be
/// distinguished from it. A full turn closes it to a ring.
Mesh BentTube(double turn_deg) {
  constexpr int kRings = 48, kSides = 16;
  const bool ring = turn_deg >= 360;
  const Mesh tube = MakeCylinder(1, 1, kSides, kRings);
  if (!ring) {
    Mesh horseshoe = tube;
    const double low = tube.points.col(2).minCoeff(), length = tube.points.col(2).maxCoeff() - low;
    for (Eigen::Index v = 0; v < tube.points.rows(); ++v) {
      const double t = (tube.points(v, 2) - low) / length,
                   angle = turn_deg * EIGEN_PI / 180 * (t - 0.5);
      const double thick = 0.25 + 0.12 * std::cos(EIGEN_PI * (t - 0.5));
      const double r = 1 + thick * tube.points(v, 0);
      horseshoe.points.row(v) << r * std::cos(angle), r * std::sin(angle),
          thick * tube.points(v, 1);
    }
    if (SignedVolume(horseshoe.points, horseshoe.faces) < 0)
      horseshoe.faces.col(1).swap(horseshoe.faces.col(2));
    return horseshoe;
  }
  Mesh mesh;
  mesh.points.resize(kRings * kSides, 3);
  mesh.faces.resize(2 * kRings * kSides, 3);
  int f = 0;
  for (int i = 0; i < kRings; ++i)
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2 * EIGEN_PI * i / kRings, around = 2 * EIGEN_PI * k / kSides,
                   thick = 0.25 + 0.12 * std::cos(angle / 2) * std::cos(angle / 2);
      const double r = 1 + thick * std::cos(around);
      mesh.points.row(i * kSides + k) << r * std::cos(angle), r * std::sin(angle),
          thick * std::sin(around);
      const int a = i * kSides + k, b = (i + 1) % kRings * kSides + k,
                c = (i + 1) % kRings * kSides + (k + 1) % kSides, d = i * kSides + (k + 1) % kSides;
      mesh.faces.row(f++) << a, b, c;
      mesh.faces.row(f++) << a, c, d;
    }
  if (SignedVolume(mesh.points, mesh.faces) < 0) mesh.faces.col(1).swap(mesh.faces.col(2));
  return mesh;
}

TEST(HandlesOf, RingHasOneAndOpenSurfacesHaveNoAnswer) {
  EXPECT_EQ(HandlesOf(BentTube(360)), 1);
  EXPECT_EQ(HandlesOf(BentTube(250)), 0);
  Mesh open = BentTube(360);
  open.faces.conservativeResize(open.faces.rows() - 3, 3);
  EXPECT_FALSE(HandlesOf(open).has_value());
}

TEST(FusedTemplateProblem, NamesWhatThePoseLacksAndNothingElse) {
  const Mesh ring = BentTube(360), horseshoe = BentTube(250);
  EXPECT_NE(FusedTemplateProblem(ring, horseshoe, 0.05).find("1 handle that"), std::string::npos);
  EXPECT_TRUE(FusedTemplateProblem(horseshoe, ring, 0.05).empty());
  EXPECT_TRUE(FusedTemplateProblem(ring, ring, 0.05).empty());
  EXPECT_TRUE(FusedTemplateProblem(ring, horseshoe, 0.002).empty())
      << "a handle of noise does no harm";
}

TEST(RegisterProgram, TemplateWhosePartsTouchIsRefusedWithItsCure) {
  const TestingFolder own;
  const fs::path folder = own.path();
  const std::string at = folder.string();
  WriteMesh(folder / "ring.ply", BentTube(360));
  WriteMesh(folder / "horseshoe.ply", BentTube(280));
  const auto run = [&](const std::string& arguments) {
    return WEXITSTATUS(std::system(
        (BinFolder() + "/keypose-register " + arguments + " > " + at + "/log 2>&1").c_str()));
  };
  const std::string to_open = "--source " + at + "/ring.ply --target " + at +
                              "/horseshoe.ply --registered " + at + "/a.ply";
  EXPECT_EQ(run(to_open), 3);
  EXPECT_NE(ReadFile(folder / "log").find("a template pose in which these parts do not touch"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "a.ply"));
  EXPECT_EQ(run(to_open + " --allow_fused true"), 0);
  // In the other direction the ends only come to touch, which is no reason to refuse.
  EXPECT_EQ(run("--source " + at + "/horseshoe.ply --target " + at + "/ring.ply --registered " +
                at + "/b.ply"),
            0);
}

}  // namespace keypose::registration::topology_test
