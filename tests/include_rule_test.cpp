#include <gtest/gtest.h>

#include <set>

#include "core/io/text/files.h"
#include "core/testing/paths.h"
#include "tests/include_rules.h"

namespace keypose::tests::include_rule_test {

const std::filesystem::path kRoot = SourceFolder();

Rooms OurRooms() {
  return ParseRooms(ReadFile(std::filesystem::path(BinFolder()).parent_path() / "rooms.txt"));
}

std::map<std::string, std::string> OurTexts() {
  std::map<std::string, std::string> texts;
  for (const std::string& file : SourceFiles(kRoot)) texts[file] = ReadFile(kRoot / file);
  return texts;
}

TEST(IncludeRules, NoFileOfTheProjectBreaksOne) {
  const Rooms rooms = OurRooms();
  const auto texts = OurTexts();
  // A search that finds no files would pass, so every room must be among the files.
  std::set<std::string> seen;
  for (const auto& [file, text] : texts) seen.insert(file.substr(0, file.find('/')));
  for (const std::string room :
       {"capture", "reconstruct", "cleanup", "texture", "register", "interpolate", "export",
        "report", "pipeline", "core", "views", "deform"})
    EXPECT_TRUE(seen.count(room)) << room;
  for (const auto& [file, text] : texts)
    for (const auto& breach : IncludeBreaches(rooms, file, text))
      ADD_FAILURE() << breach.place << ": " << breach.reason;
}

TEST(IncludeRules, RoomsLinkDownwardsOnly) {
  const Rooms rooms = OurRooms();
  EXPECT_GT(rooms.size(), 35u);
  for (const auto& breach : LinkBreaches(rooms))
    ADD_FAILURE() << breach.place << ": " << breach.reason;
}

TEST(IncludeRules, NoUnitReachesItself) {
  for (const auto& breach : UnitCycles(OurTexts()))
    ADD_FAILURE() << breach.place << ": " << breach.reason;
}

const char* const kHouse =
    "keypose_core_values core/values values\n"
    "keypose_core_surfaces core/surfaces values keypose_core_values\n"
    "keypose_io_text core/io/text files keypose_core_values\n"
    "keypose_io_meshes core/io/meshes files keypose_io_text keypose_core_values\n"
    "keypose_core_stage core/stage files keypose_io_text keypose_core_values\n"
    "keypose_pipeline_graph pipeline/graph files\n"
    "keypose_pipeline_run pipeline/run files keypose_pipeline_graph\n"
    "keypose_deform_arap deform/arap values\n"
    "keypose_register_nricp register/nricp values keypose_deform_arap\n"
    "keypose_register_auto register/auto values keypose_register_nricp\n"
    "keypose_reconstruct_sfm reconstruct/sfm files\n"
    "keypose_cleanup_repair cleanup/repair values\n"
    "keypose_interpolate interpolate values keypose_deform_arap\n";

void ExpectBreach(const std::string& file, const std::string& line, bool breach) {
  const auto found = IncludeBreaches(ParseRooms(kHouse), file, "// a comment\n" + line + "\n");
  EXPECT_EQ(found.size(), breach ? 1u : 0u) << file << " with " << line;
  for (const auto& b : found) EXPECT_EQ(b.place, file + ":2");
}

TEST(IncludeRules, StageRoomsDoNotIncludeEachOtherOrLookUp) {
  ExpectBreach("register/nricp/nricp.cpp", "#include \"cleanup/repair/holes.h\"", true);
  ExpectBreach("register/register_stage.cpp", "#include \"cleanup/repair/holes.h\"", true);
  ExpectBreach("register/nricp_test.cpp", "#include \"synth/worlds/world.h\"", true);
  ExpectBreach("register/nricp/nricp.cpp", "#include \"pipeline/graph/graph.h\"", true);
  ExpectBreach("deform/arap/arap_fit.cpp", "#include \"register/nricp/nricp.h\"", true);
  ExpectBreach("core/surfaces/geometry.cpp", "#include \"core/io/meshes/mesh_io.h\"", true);
  ExpectBreach("core/io/meshes/mesh_io.cpp", "#include \"core/stage/stage.h\"", true);
  ExpectBreach("core/stage/stage.cpp", "#include \"core/io/meshes/mesh_io.h\"", true);
  ExpectBreach("core/stage/stage.cpp", "#include \"core/io/text/files.h\"", false);
  ExpectBreach("core/values/mesh.cpp", "#include \"core/surfaces/geometry.h\"", true);
  ExpectBreach("core/surfaces/geometry.cpp", "#include \"core/values/mesh.h\"", false);
  ExpectBreach("core/surfaces/geometry_test.cpp", "#include \"core/io/meshes/mesh_io.h\"", false);
  ExpectBreach("pipeline/graph/graph.cpp", "#include \"pipeline/run/plan.h\"", true);
  ExpectBreach("pipeline/run/plan.cpp", "#include \"pipeline/graph/graph.h\"", false);
  ExpectBreach("pipeline/graph/graph.cpp", "#include \"core/stage/stage.h\"", true);
  ExpectBreach("pipeline/graph/graph.cpp", "#include \"studio/server/server.h\"", true);
  ExpectBreach("studio/routes/routes.cpp", "#include \"pipeline/graph/graph.h\"", false);
  ExpectBreach("studio/routes/routes.cpp", "#include \"register/nricp/nricp.h\"", true);
  ExpectBreach("pipeline/graph/graph.cpp", "#include \"core/io/text/files.h\"", false);
  ExpectBreach("register/nricp/nricp.cpp", "#include \"core/surfaces/geometry.h\"", false);
  ExpectBreach("register/nricp/nricp.cpp", "#include \"register/nricp/nricp.h\"", false);
  ExpectBreach("core/io/project/poses_io_test.cpp", "#include \"core/stage/stage.h\"", false);
}

TEST(IncludeRules, SubRoomsIncludeWhatTheyLink) {
  ExpectBreach("register/auto/auto_fit.cpp", "#include \"register/nricp/nricp.h\"", false);
  ExpectBreach("register/nricp/nricp.cpp", "#include \"register/auto/auto_fit.h\"", true);
  ExpectBreach("register/nricp/nricp.cpp", "#include \"deform/arap/arap_fit.h\"", false);
  // Not linked directly, only by a linked room: a test may include it; an algorithm must link it
  // first.
  ExpectBreach("register/auto/auto_fit.cpp", "#include \"deform/arap/arap_fit.h\"", true);
  ExpectBreach("register/auto/auto_fit_test.cpp", "#include \"deform/arap/arap_fit.h\"", false);
  ExpectBreach("register/nricp/nricp_test.cpp", "#include \"register/auto/auto_fit.h\"", true);
  // A room's programs may include all of the room. Other files in the room's root folder, in a
  // target of their own, may not.
  ExpectBreach("register/register_stage.cpp", "#include \"register/auto/auto_fit.h\"", false);
  ExpectBreach("interpolate/sequence.cpp", "#include \"interpolate/turns/turns.h\"", true);
  ExpectBreach("register/nricp/nricp_test.cpp", "#include \"register/testing/scenes.h\"", false);
}

TEST(IncludeRules, OnlyProgramsTestsAndDeclaredRoomsTouchFiles) {
  ExpectBreach("cleanup/repair/holes.cpp", "#include \"core/io/meshes/mesh_io.h\"", true);
  ExpectBreach("cleanup/repair/holes.h", "#include \"core/io/meshes/mesh_io.h\"", true);
  ExpectBreach("cleanup/cleanup_stage.cpp", "#include \"core/io/meshes/mesh_io.h\"", false);
  ExpectBreach("cleanup/repair/holes_test.cpp", "#include \"core/io/meshes/mesh_io.h\"", false);
  ExpectBreach("reconstruct/sfm/strategies.cpp", "#include \"core/io/meshes/mesh_io.h\"", false);
  ExpectBreach("interpolate/sequence.cpp", "#include \"core/io/meshes/mesh_io.h\"", true);
}

TEST(IncludeRules, HeavyLibrariesStayInsideSources) {
  for (const std::string library : {"CGAL/Surface_mesh.h", "pcl/point_cloud.h", "ceres/ceres.h",
                                    "opencv2/core.hpp", "embree3/rtcore.h", "tetgen.h"}) {
    ExpectBreach("texture/bake.h", "#include <" + library + ">", true);
    ExpectBreach("texture/bake.h", "  #  include <" + library + ">  // why", true);
    ExpectBreach("texture/bake.cpp", "#include <" + library + ">", false);
  }
}

TEST(IncludeRules, HeadersOfCoreNeedOnlyEigenAndTheStandardLibrary) {
  ExpectBreach("core/values/mesh.h", "#include <nlohmann/json.hpp>", true);
  ExpectBreach("core/io/testing/mesh_files.h", "#include <gtest/gtest.h>", false);
  ExpectBreach("core/values/mesh.h", "#include <Eigen/Core>", false);
  ExpectBreach("core/values/mesh.h", "#include <vector>", false);
  ExpectBreach("core/io/meshes/mesh_io.h", "#include <nlohmann/json.hpp>", true);
  ExpectBreach("core/values/mesh.cpp", "#include <nlohmann/json.hpp>", false);
}

TEST(IncludeRules, ProjectHeadersAreNamedFromTheRoot) {
  ExpectBreach("texture/bake.cpp", "#include \"bake.h\"", true);
}

TEST(LinkRules, CirclesStrangersAndOtherStageRoomsAreFound) {
  EXPECT_TRUE(LinkBreaches(ParseRooms(kHouse)).empty());
  const auto breaches = [](const std::string& more) {
    return LinkBreaches(ParseRooms(kHouse + more)).size();
  };
  EXPECT_EQ(breaches("keypose_cleanup_wrap cleanup/wrap values keypose_register_nricp\n"), 1u);
  EXPECT_EQ(breaches("keypose_cleanup_wrap cleanup/wrap values keypose_nothing\n"), 1u);
  EXPECT_EQ(
      breaches("keypose_a cleanup/a values keypose_b\nkeypose_b cleanup/b values keypose_a\n"), 2u);
}

TEST(UnitRules, HeaderAndSourceCountAsOne) {
  EXPECT_TRUE(UnitCycles({{"a.h", "#include \"b.h\""}, {"a.cpp", "#include \"a.h\""}, {"b.h", ""}})
                  .empty());
  EXPECT_TRUE(
      UnitCycles({{"a_impl.h", "#include \"a.h\""}, {"a.cpp", "#include \"a_impl.h\""}}).empty());
  // No two headers include each other, but neither unit can be understood without the other.
  const auto circle =
      UnitCycles({{"a.h", "#include \"b.h\""}, {"b.cpp", "#include \"a.h\""}, {"b.h", ""}});
  ASSERT_EQ(circle.size(), 2u);
  EXPECT_EQ(circle[0].reason, "reaches itself: a -> b -> a");
}

}  // namespace keypose::tests::include_rule_test
