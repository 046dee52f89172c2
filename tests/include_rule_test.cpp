#include <gtest/gtest.h>

#include <set>

#include "core/io/files.h"
#include "tests/include_rules.h"

namespace keypose::tests {
namespace {

TEST(IncludeRules, NoFileOfTheProjectBreaksOne) {
  const std::filesystem::path root = KEYPOSE_SOURCE_DIR;
  const auto files = SourceFiles(root);
  // A walk that finds nothing would pass: every room must be among the files.
  std::set<std::string> rooms;
  for (const auto& file : files) rooms.insert(file.substr(0, file.find('/')));
  for (const std::string room :
       {"capture", "reconstruct", "cleanup", "texture", "register", "interpolate", "export", "report", "pipeline", "core"})
    EXPECT_TRUE(rooms.count(room)) << room;
  for (const auto& file : files) {
    for (const auto& breach : IncludeBreaches(file, ReadFile(root / file))) ADD_FAILURE() << breach.place << ": " << breach.reason;
  }
}

void ExpectBreach(const std::string& file, const std::string& line, bool breach) {
  const auto found = IncludeBreaches(file, "// a comment\n" + line + "\n");
  EXPECT_EQ(found.size(), breach ? 1u : 0u) << file << " with " << line;
  for (const auto& b : found) EXPECT_EQ(b.place, file + ":2");
}

TEST(IncludeRules, StageRoomsDoNotIncludeEachOtherOrLookUp) {
  ExpectBreach("register/nricp.cpp", "#include \"cleanup/repair.h\"", true);
  ExpectBreach("register/nricp_test.cpp", "#include \"synth/world.h\"", true);
  ExpectBreach("register/nricp.cpp", "#include \"pipeline/graph.h\"", true);
  ExpectBreach("pipeline/graph.cpp", "#include \"core/stage/stage.h\"", true);
  ExpectBreach("core/geometry.cpp", "#include \"core/io/mesh_io.h\"", true);
  ExpectBreach("core/io/mesh_io.cpp", "#include \"core/stage/stage.h\"", true);
  ExpectBreach("core/stage/stage.cpp", "#include \"core/io/mesh_io.h\"", true);
  ExpectBreach("core/stage/stage.cpp", "#include \"core/io/files.h\"", false);
  ExpectBreach("register/nricp.cpp", "#include \"core/geometry.h\"", false);
  ExpectBreach("register/nricp.cpp", "#include \"register/nricp.h\"", false);
  ExpectBreach("core/io/io_test.cpp", "#include \"core/stage/stage.h\"", false);
}

TEST(IncludeRules, OnlyProgramsAndTestsTouchFiles) {
  ExpectBreach("cleanup/repair.cpp", "#include \"core/io/mesh_io.h\"", true);
  ExpectBreach("cleanup/repair.h", "#include \"core/io/mesh_io.h\"", true);
  ExpectBreach("cleanup/cleanup_stage.cpp", "#include \"core/io/mesh_io.h\"", false);
  ExpectBreach("cleanup/repair_test.cpp", "#include \"core/io/mesh_io.h\"", false);
}

TEST(IncludeRules, HeavyLibrariesStayInsideSources) {
  for (const std::string library :
       {"CGAL/Surface_mesh.h", "pcl/point_cloud.h", "ceres/ceres.h", "opencv2/core.hpp", "embree3/rtcore.h", "tetgen.h"}) {
    ExpectBreach("texture/bake.h", "#include <" + library + ">", true);
    ExpectBreach("texture/bake.h", "  #  include <" + library + ">  // why", true);
    ExpectBreach("texture/bake.cpp", "#include <" + library + ">", false);
  }
}

TEST(IncludeRules, HeadersOfCoreNeedOnlyEigenAndTheStandardLibrary) {
  ExpectBreach("core/mesh.h", "#include <nlohmann/json.hpp>", true);
  ExpectBreach("core/mesh.h", "#include <Eigen/Core>", false);
  ExpectBreach("core/mesh.h", "#include <vector>", false);
  ExpectBreach("core/io/mesh_io.h", "#include <nlohmann/json.hpp>", true);
  ExpectBreach("core/mesh.cpp", "#include <nlohmann/json.hpp>", false);
}

TEST(IncludeRules, ProjectHeadersAreNamedFromTheRoot) { ExpectBreach("texture/bake.cpp", "#include \"bake.h\"", true); }

}  // namespace
}  // namespace keypose::tests
