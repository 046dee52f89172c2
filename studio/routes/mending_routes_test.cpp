#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "studio/routes/routes.h"

namespace keypose::studio::mending_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The mesh comes from the test; `mend` is Keypose's own, and what follows copies.
constexpr char kProject[] = R"(name: ball
poses: {rest: photos/rest}
template: rest
steps:
  capture: {enabled: false}
  sfm: {enabled: false}
  masks: {enabled: false}
  dense: {enabled: false}
  mesh: {enabled: false}
  refine: {enabled: false}
  cleanup: {program: tools/cleanup, inputs: {surface: ./ball.ply, images: null, model: null}}
  unwrap: {program: tools/unwrap}
  register: {enabled: false}
  fit: {enabled: false}
  interpolate: {enabled: false}
  locate: {enabled: false}
  composite: {enabled: false}
  bake: {enabled: false}
  complete: {enabled: false}
  export: {enabled: false}
  report: {enabled: false}
)";

constexpr char kCopy[] = R"sh(#!/bin/sh
if [ "$1" = --describe ]; then
  cat "$(readlink -f "$0").json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --surface) from="$2" ;;
    --unwrapped) to="$2" ;;
    --clean) if [ -z "$from" ]; then from="$2"; else to="$2"; fi ;;
    --report) echo '{"schema": 1, "measurements": {}}' > "$2" ;;
  esac
  shift 2
done
cp "$from" "$to"
)sh";

class MendingRoutes : public ::testing::Test, public TestingFolder {
 protected:
  static void SetUpTestSuite() {
    own_made = std::make_unique<TestingFolder>();
    fs::create_directories(own_made->path() / "tools");
    fs::create_directories(own_made->path() / "photos/rest");
    WriteMesh(own_made->path() / "ball.ply", MakeIcosphere(4));
    AddTool("cleanup", "surface", "clean");
    AddTool("unwrap", "clean", "unwrapped");
    WriteFile(own_made->path() / "pipeline.yaml", kProject);
    Run(own_made->path());
  }
  static void TearDownTestSuite() { own_made.reset(); }
  MendingRoutes() {
    fs::copy(own_made->path(), folder_, fs::copy_options::recursive);
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~MendingRoutes() override { routes_.reset(); }

  static void AddTool(const std::string& name, const char* input, const char* output) {
    const fs::path program = own_made->path() / "tools" / name;
    WriteFile(program, kCopy);
    fs::permissions(program, fs::perms::owner_all);
    json inputs = json::array({{{"name", input}, {"kind", "file"}}});
    if (name == "cleanup")
      for (const char* more : {"images", "model"})
        inputs.push_back({{"name", more}, {"kind", "folder"}, {"optional", true}});
    const json description = {
        {"schema", 1},
        {"stage", name},
        {"version", "1"},
        {"summary", "copies"},
        {"inputs", inputs},
        {"outputs",
         json::array(
             {{{"name", output}, {"kind", "file"}, {"file", output + std::string(".ply")}}})},
        {"options", json::array()}};
    WriteFile(program.string() + ".json", description.dump());
  }
  static void Run(const fs::path& folder) {
    const fs::path log = folder / "log.txt";
    const std::string command =
        BinFolder() + "/keypose run -C " + folder.string() + " > " + log.string() + " 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(log);
  }
  json Get() {
    const Answer answer = routes_->Handle({"GET", "/api/mending", {{"pose", "rest"}}, ""});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }
  Answer Put(const json& strokes, const std::string& revision) {
    const json body = {{"revision", revision}, {"strokes", strokes}};
    return routes_->Handle({"PUT", "/api/mending", {{"pose", "rest"}}, body.dump()});
  }
  Answer Draft(const json& strokes) {
    const json body = {{"strokes", strokes}};
    return routes_->Handle({"POST", "/api/mending/draft", {{"pose", "rest"}}, body.dump()});
  }
  static json Stroke(const char* tool, double radius, double strength, int face) {
    const json place = {{"face", face}, {"barycentric", {1, 0, 0}}};
    return {{"tool", tool},
            {"radius", radius},
            {"strength", strength},
            {"places", json::array({place})}};
  }

  static inline std::unique_ptr<TestingFolder> own_made;
  const Mesh ball_ = MakeIcosphere(4);
  std::unique_ptr<Routes> routes_;
};

TEST_F(MendingRoutes, AStrokeIsDraftedSavedAndRun) {
  const json none = Get();
  EXPECT_EQ(none.at("revision"), "");
  EXPECT_EQ(none.at("problem"), "");
  EXPECT_EQ(none.at("strokes").size(), 0U);
  EXPECT_THAT(none.at("again").at("follow"), ElementsAre("unwrap/rest"));
  const json strokes = json::array({Stroke("pull", 0.3, 0.5, 40)});
  const Answer draft = Draft(strokes);
  ASSERT_EQ(draft.status, 200) << draft.bytes;
  const std::size_t vertices = static_cast<std::size_t>(ball_.vertex_count());
  std::vector<float> numbers(draft.bytes.size() / 4);
  std::memcpy(numbers.data(), draft.bytes.data(), 4 * numbers.size());
  ASSERT_EQ(numbers.size(), 3 * vertices + 2);
  EXPECT_NEAR(numbers.back(), 0.15, 1e-6);
  const auto pulled = static_cast<std::size_t>(ball_.faces(40, 0));
  const auto length = [&](std::size_t v) {
    return Eigen::Vector3f(numbers[3 * v], numbers[3 * v + 1], numbers[3 * v + 2]).norm();
  };
  EXPECT_NEAR(length(pulled), 1.15, 0.001);

  ASSERT_EQ(Put(strokes, "").status, 200);
  EXPECT_EQ(Put(strokes, "").status, 409) << "the file is another by now";
  const json saved = Get();
  ASSERT_EQ(saved.at("strokes").size(), 1U);
  EXPECT_EQ(saved.at("strokes")[0].at("places")[0].at("face"), 40);
  EXPECT_EQ(saved.at("strokes")[0].at("fault"), "");
  EXPECT_EQ(saved.at("again").at("step"), "mend/rest");
  Run(folder_);
  const Mesh mended = ReadMesh(folder_ / "out/rest/mended.ply");
  EXPECT_NEAR(mended.points.row(ball_.faces(40, 0)).norm(), 1.15, 0.001);
  EXPECT_EQ(ReadMesh(folder_ / "out/rest/mesh.obj").points, mended.points) << "unwrap takes it";

  ASSERT_EQ(Put(json::array(), saved.at("revision")).status, 200);
  EXPECT_FALSE(fs::exists(folder_ / "mending/rest.json"));
  Run(folder_);
  EXPECT_NEAR(ReadMesh(folder_ / "out/rest/mesh.obj").points.row(ball_.faces(40, 0)).norm(), 1,
              1e-6);
}

TEST_F(MendingRoutes, WhatCannotBeDoneIsRefusedByName) {
  EXPECT_THAT(Draft(json::array({Stroke("smooth", 0.3, 1, 1), Stroke("fill", 5, 1, 2)})).bytes,
              HasSubstr("stroke 2 (fill): the brush covers a whole piece"));
  EXPECT_THAT(Draft(json::array({Stroke("fill", 0.3, 1, 999999)})).bytes,
              HasSubstr("the page shows an older mesh"));
  EXPECT_EQ(Draft(json::array({Stroke("fill", -1, 1, 1)})).status, 400);
  EXPECT_EQ(Put(json::array({Stroke("carve", 0.1, 1, 1)}), "").status, 400);
  EXPECT_FALSE(fs::exists(folder_ / "mending/rest.json"));
}

TEST_F(MendingRoutes, StrokesThatAreLostAreShownAndStopTheRun) {
  const json lost = {{"tool", "fill"}, {"radius", 0.1}, {"places", {{0, 0, 3}}}};
  const json good = {{"tool", "smooth"}, {"radius", 0.3}, {"places", {{0, 0, 1}}}};
  fs::create_directories(folder_ / "mending");
  WriteFile(folder_ / "mending/rest.json", json{{"strokes", {good, lost}}}.dump());
  routes_ = std::make_unique<Routes>(folder_);
  const json read = Get();
  ASSERT_EQ(read.at("strokes").size(), 2U);
  EXPECT_EQ(read.at("strokes")[0].at("fault"), "");
  EXPECT_THAT(read.at("strokes")[1].at("fault").get<std::string>(), HasSubstr("off the mesh"));
  const fs::path log = folder_ / "log.txt";
  const std::string command =
      BinFolder() + "/keypose run -C " + folder_.string() + " > " + log.string() + " 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 3);
  EXPECT_THAT(ReadFile(log),
              HasSubstr("1 of 2 strokes do not lie on the mesh any more (stroke 2 (fill): "));
}

/// A figure with a nose, and an arm to each side of x = 0.
Mesh TwoArms() {
  Mesh mesh = MakeIcosphere(4);
  const auto bump = [](const Eigen::Vector3d& p, const Eigen::Vector3d& at) {
    return std::exp(-16 * (p - at.normalized()).squaredNorm());
  };
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d p = mesh.points.row(v);
    const double length =
        1 + 0.9 * bump(p, {1, 0, 0.2}) + 0.9 * bump(p, {-1, 0, 0.2}) + 0.6 * bump(p, {0, -1, 0.6});
    mesh.points.row(v) = (length * p).cwiseProduct(Eigen::Vector3d(0.8, 0.5, 1.3));
    mesh.points(v, 1) -= 0.4 * p[2] * std::abs(p[2]);
  }
  return mesh;
}

TEST_F(MendingRoutes, LandmarksOfOneHalfAreMirroredWhereTheyHaveNoPartner) {
  const Mesh figure = TwoArms();
  WriteMesh(folder_ / "ball.ply", figure);
  Run(folder_);
  routes_ = std::make_unique<Routes>(folder_);
  const RayScene scene(figure.points, figure.faces);
  const auto at = [&](const char* name, const Eigen::Vector3d& place) {
    const RayScene::Foot foot = scene.ClosestPoint(place);
    return Landmark{name, foot.face, foot.barycentric};
  };
  fs::create_directories(folder_ / "landmarks");
  const std::vector<Landmark> picks = {at("left hand", {1.5, 0, 0.3}), at("nose", {0, -1, 0.9}),
                                       at("ear.L", {0.5, 0, 1.1}), at("ear.R", {-0.5, 0, 1.1})};
  WriteLandmarks(folder_ / "landmarks/rest.json", figure, picks);
  const Answer answer = routes_->Handle({"GET", "/api/landmarks/mirrored", {{"pose", "rest"}}, ""});
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  const json found = json::parse(answer.bytes).at("mirrored");
  ASSERT_EQ(found.size(), 1U) << found << ": the nose is in the middle, the ears have each other";
  EXPECT_EQ(found[0].at("of"), "left hand");
  Landmark other;
  other.face = found[0].at("source").at("face");
  for (std::size_t k = 0; k < 3; ++k)
    other.barycentric[static_cast<int>(k)] = found[0].at("source").at("barycentric").at(k);
  const Eigen::Vector3d hand = PositionOf(picks[0], figure);
  const Eigen::Vector3d wanted = hand.cwiseProduct(Eigen::Vector3d(-1, 1, 1));
  EXPECT_LT((PositionOf(other, figure) - wanted).norm(), 0.06);
  EXPECT_EQ(found[0].at("target").at("face"), other.face) << "the net lies on the scan";
}

}  // namespace keypose::studio::mending_routes_test
