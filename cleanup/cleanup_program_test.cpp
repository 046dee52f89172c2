#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cleanup/repair/handle_loops.h"
#include "cleanup/support/unseen.h"
#include "cleanup/testing/camera_ring.h"
#include "cleanup/testing/pawn.h"
#include "cleanup/testing/windowed_slab.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/testing/shots.h"

namespace keypose::cleanup::cleanup_program_test {

namespace fs = std::filesystem;

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

const Window kNarrow = {3, 6, 3, 6}, kBroad = {9, 16, 2, 7}, kThird = {17, 20, 3, 6};

TEST(CleanupProgram, LooksThroughHandlesAndWarnsWithoutPhotographs) {
  const TestingFolder own;
  const fs::path folder = own.path();
  WriteShot(folder, PhotographOfSlab(Slab({kNarrow}), {-15, 0, 15}));
  WriteMesh(folder / "slab.ply", Slab({kNarrow, kBroad}));
  const std::string at = folder.string();
  const auto run = [&](const std::string& more) {
    const std::string command = BinFolder() + "/keypose-cleanup --surface " + at +
                                "/slab.ply --clean " + at + "/clean.ply --report " + at +
                                "/report.json " + more + " > " + at + "/log 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  ASSERT_EQ(run("--images " + at + "/images --model " + at + "/model"), 0)
      << ReadFile(folder / "log");
  const Mesh seen = ReadMesh(folder / "clean.ply");
  EXPECT_EQ(Genus(seen), 1);
  EXPECT_TRUE(Open(seen, kNarrow));
  ASSERT_EQ(run(""), 0);
  EXPECT_EQ(Genus(ReadMesh(folder / "clean.ply")), 0);
  EXPECT_NE(ReadFile(folder / "report.json").find("--genus 2"), std::string::npos)
      << "the warning says how to keep them";
  ASSERT_EQ(run("--genus 2"), 0);
  EXPECT_EQ(Genus(ReadMesh(folder / "clean.ply")), 2);
  EXPECT_EQ(run("--genus 3"), 3);
  EXPECT_EQ(run("--images " + at + "/images"), 2);
}

using Eigen::Vector3d;

TEST(CleanupProgram, SaysHowMuchPhotographsOfOneSideDoNotSee) {
  const TestingFolder own;
  const std::string at = own.path().string();
  Mesh ball = MakeIcosphere(4);
  ball.points.col(2).array() += 1;
  // Four cameras of twelve, over a quarter of the way round.
  MaskShot shot = MasksOf(ball, Ring({0, 0, 1}, 20, 4));
  WriteShot(own.path(), shot);
  WriteMesh(own.path() / "ball.ply", ball);
  const std::string command = BinFolder() + "/keypose-cleanup --surface " + at +
                              "/ball.ply --images " + at + "/images --model " + at +
                              "/model --clean " + at + "/clean.ply --report " + at +
                              "/report.json > " + at + "/log 2>&1";
  ASSERT_EQ(WEXITSTATUS(std::system(command.c_str())), 0) << ReadFile(own.path() / "log");
  const auto measured = nlohmann::json::parse(ReadFile(own.path() / "report.json"))["measurements"];
  const UnseenSurface truth = MeasureUnseen(ball, shot.views);
  EXPECT_GT(truth.share, 0.3);
  EXPECT_NEAR(measured["unseen_share"], truth.share, 0.01);
}

}  // namespace keypose::cleanup::cleanup_program_test
