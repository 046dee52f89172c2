// Every file of the collection of broken meshes gives a closed mesh or is refused with a reason,
// whatever its unit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <vector>

#include "cleanup/repair/intersections.h"
#include "cleanup/strategies/cleanup.h"
#include "core/io/meshes/mesh_io.h"
#include "core/surfaces/geometry.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"

namespace keypose::cleanup::bad_meshes_test {

namespace fs = std::filesystem;

fs::path Data() { return DataFolder(); }

std::vector<fs::path> BadMeshes() {
  const fs::path folder = Data() / "bad_meshes";
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() != ".tsv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// The result of local repair intersects itself after rounding in the file's own unit, so a wrap is
// correct. Counts of the failed strategies are not reported.
TEST(BadMeshes, ATryThatCrossesItselfGivesWayToTheNextAndCountsForNothing) {
  const fs::path file = Data() / "mutants" / "nc.obj";
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file << "; set KEYPOSE_DATA to the data folder";
  const CleanupResult result = MakeClosedManifold(ReadMesh(file), CleanupOptions{});
  EXPECT_EQ(result.self_intersections, 0);
  EXPECT_LE(result.handles_cut, result.genus_before - result.genus);
  EXPECT_EQ(result.strategy.substr(0, 2), "R4");
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

// The result for a file in another unit; nothing when it is refused.
std::optional<Mesh> CleanedAt(const Mesh& surface, double scale, const CleanupOptions& options) {
  Mesh scaled = surface;
  scaled.points *= scale;
  try {
    return MakeClosedManifold(scaled, options).mesh;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

TEST(BadMeshes, AnotherUnitGivesTheSameFacesAndPlaces) {
  const std::vector<fs::path> files = BadMeshes();
  if (files.empty()) GTEST_SKIP() << "no bad_meshes; set KEYPOSE_DATA to the data folder";
  CleanupOptions options;
  options.faces = KEYPOSE_BAD_MESH_FACES;
  for (std::size_t i = 0; i < files.size(); i += KEYPOSE_BAD_MESH_UNIT_STEP) {
    SCOPED_TRACE(files[i].filename().string());
    const Mesh surface = ReadMesh(files[i]);
    const std::optional<Mesh> one = CleanedAt(surface, 1, options);
    for (const double scale : {0.001, 1000.0}) {
      SCOPED_TRACE(scale);
      const std::optional<Mesh> other = CleanedAt(surface, scale, options);
      ASSERT_EQ(one.has_value(), other.has_value());
      if (!one) continue;
      EXPECT_EQ(one->faces, other->faces);
      if (one->points.rows() != other->points.rows()) continue;
      EXPECT_LT((other->points / scale - one->points).rowwise().norm().maxCoeff(),
                1e-6 * BoundingDiagonal(one->points));
    }
  }
}

}  // namespace keypose::cleanup::bad_meshes_test
