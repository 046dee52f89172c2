// Picks read from JSON: places on a mesh, pixels, numbers, and what is said of faults.
#include "core/io/text/json_pick.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::json_pick_test {

using nlohmann::json;
using ::testing::HasSubstr;

/// What `read` says of the pick's fault.
template <class Read>
std::string FaultOf(const char* text, const Read& read) {
  const json pick = json::parse(text);
  try {
    read(JsonPick<json>(pick, "p.json", "pick", 3));
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << text << " was read";
  return "";
}

std::string PlaceFault(const char* text) {
  return FaultOf(text, [](const JsonPick<json>& pick) { pick.Point(MakeIcosphere(1), "body"); });
}

TEST(JsonPick, PlacesAreAVertexOrAPointOfAFace) {
  const Mesh mesh = MakeIcosphere(1);
  const json vertex = json::parse(R"({"vertex": 7})");
  EXPECT_EQ(PositionOf(JsonPick<json>(vertex, "p", "pick", 1).Point(mesh, "mesh"), mesh.points),
            mesh.points.row(7).transpose());
  const json face = json::parse(R"({"face": 5, "barycentric": [0.25, 0.25, 0.5]})");
  const SurfacePoint point = JsonPick<json>(face, "p", "pick", 1).Point(mesh, "mesh");
  EXPECT_EQ(point.vertices, mesh.faces.row(5).transpose());
  EXPECT_EQ(point.weights, Eigen::Vector3d(0.25, 0.25, 0.5));
}

TEST(JsonPick, FaultsOfPlacesAreNamed) {
  EXPECT_THAT(PlaceFault(R"({"vertex": 42})"),
              HasSubstr("p.json: pick 3 has vertex 42, but the body has 42 vertices"));
  EXPECT_THAT(PlaceFault(R"({"name": "ear", "face": -1, "barycentric": [1, 0, 0]})"),
              HasSubstr("p.json: pick 'ear' has face -1, but the body has 80 faces"));
  EXPECT_THAT(PlaceFault(R"({"vertex": 1.5})"), HasSubstr("'vertex' that is not a whole number"));
  EXPECT_THAT(PlaceFault(R"({"vertex": 99999999999})"), HasSubstr("vertex 99999999999"));
  for (const char* both : {R"({"vertex": 1, "face": 2, "barycentric": [1, 0, 0]})", "{}"})
    EXPECT_THAT(PlaceFault(both), HasSubstr("either a 'vertex', or a 'face'"));
  EXPECT_THAT(PlaceFault(R"({"face": 2})"), HasSubstr("'barycentric': a list of 3 numbers"));
  for (const char* shares : {"[1, 1, 0]", "[1.01, -0.01, 0]", "[0.3, 0.3, 0.3]"}) {
    const std::string text = std::string(R"({"face": 2, "barycentric": )") + shares + "}";
    EXPECT_THAT(PlaceFault(text.c_str()), HasSubstr("do not lie in its triangle")) << shares;
  }
}

TEST(JsonPick, RoundedCoordinatesLieInTheirTriangle) {
  EXPECT_TRUE(IsInTriangle({0.3333333, 0.3333333, 0.3333334}));
  EXPECT_TRUE(IsInTriangle({1.0000005, -0.0000005, 0}));
  EXPECT_FALSE(IsInTriangle({0.333, 0.333, 0.333}));
  EXPECT_FALSE(IsInTriangle({NAN, 0.5, 0.5}));
}

TEST(JsonPick, PixelsNumbersAndNames) {
  const json fine = json::parse(R"({"name": "ear", "pixel": [640, 0]})");
  const JsonPick<json> pick(fine, "p.json", "click", 1);
  EXPECT_EQ(pick.title(), "click 'ear'");
  EXPECT_EQ(pick.Name(), "ear");
  EXPECT_FALSE(pick.HasPlace());
  EXPECT_EQ(pick.Pixel(640, 480, "the picture"), Eigen::Vector2d(640, 0));
  const auto pixel = [](const JsonPick<json>& read) { read.Pixel(640, 480, "the picture"); };
  EXPECT_THAT(FaultOf(R"({"pixel": [641, 2]})", pixel),
              HasSubstr("pick 3 has pixel [641, 2], but the picture has 640 x 480 pixels"));
  EXPECT_THAT(FaultOf(R"({"pixel": [1, "2"]})", pixel), HasSubstr("a list of 2 numbers"));
  EXPECT_THAT(FaultOf("[3]", pixel), HasSubstr("p.json: pick 3 is not an object"));
  EXPECT_THAT(FaultOf(R"({"name": 4})", [](const JsonPick<json>& read) { read.Name(); }),
              HasSubstr("pick 3 needs a 'name'"));
}

TEST(ReadJson, FaultsNameTheFile) {
  const TestingFolder folder;
  const auto path = folder.path() / "pick.json";
  WriteFileAtomically(path, R"({"a": [1]})");
  EXPECT_EQ(ReadJson<json>(path)["a"][0], 1);
  for (const std::string& bad : {std::string("{"), std::string(200, '[')}) {
    WriteFileAtomically(path, bad);
    try {
      ReadJson<json>(path);
      ADD_FAILURE() << bad;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.filename().string()));
    }
  }
}

}  // namespace keypose::json_pick_test
