// Every file of the collection of broken meshes comes out closed, or is refused with a reason.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <vector>

#include "cleanup/cleanup.h"
#include "cleanup/intersections.h"
#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/mesh_io.h"

namespace keypose::cleanup {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> BadMeshes() {
  const char* data = std::getenv("KEYPOSE_DATA");
  const fs::path folder = fs::path(data ? data : KEYPOSE_SOURCE_DIR "/../shared/data") / "bad_meshes";
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() != ".tsv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

TEST(BadMeshes, EachComesOutClosedOrIsRefused) {
  const std::vector<fs::path> files = BadMeshes();
  if (files.empty()) GTEST_SKIP() << "no bad_meshes; set KEYPOSE_DATA to the data folder";
  std::set<std::string> refused;
  CleanupOptions options;
  options.faces = KEYPOSE_BAD_MESH_FACES;
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.filename().string());
    try {
      const CleanupResult result = MakeClosedManifold(ReadMesh(file), options);
      EXPECT_TRUE(CheckClosed(result.mesh).closed());
      EXPECT_FALSE(SelfIntersects(result.mesh));
      EXPECT_LE(result.mesh.face_count(), 1.01 * options.faces);
    } catch (const InputError& error) {
      EXPECT_GT(std::string(error.what()).size(), 20u);
      refused.insert(file.filename().string());
    }
  }
  EXPECT_EQ(refused, std::set<std::string>{"tm_empty.obj"});
}

}  // namespace
}  // namespace keypose::cleanup
