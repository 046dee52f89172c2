// Suggestions on real pairs with known correspondence, where they are at hand; prints the table of docs/results/landmarks.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <sstream>

#include "core/geometry.h"
#include "core/io/files.h"
#include "core/io/mesh_io.h"
#include "register/suggest.h"

namespace keypose::registration {
namespace {

struct Known {
  const char* name;
  const char* truth;         ///< file of lines `source_vertex target_vertex`
  double dense_mean;         ///< bound, over the diagonal; 1.3 times what was measured
  int suggestions_within_5;  ///< of 12, at least; one less than measured
};

class SuggestPairs : public testing::TestWithParam<Known> {};

std::vector<int> ReadTruth(const std::filesystem::path& path, int vertices) {
  std::vector<int> truth(static_cast<std::size_t>(vertices), -1);
  std::istringstream in(ReadFile(path));
  for (int s = 0, t = 0; in >> s >> t;) truth[static_cast<std::size_t>(s)] = t;
  return truth;
}

int VertexOf(const Mesh& mesh, int face, const Eigen::Vector3d& barycentric) {
  Eigen::Index k = 0;
  barycentric.maxCoeff(&k);
  return mesh.faces(face, k);
}

/// Truth of the nearest vertex that has one.
int NearestTruth(const Mesh& source, const std::vector<int>& truth, int vertex) {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const double d = (source.points.row(static_cast<Eigen::Index>(v)) - source.points.row(vertex)).squaredNorm();
    if (truth[v] >= 0 && d < least) least = d, best = truth[v];
  }
  return best;
}

TEST_P(SuggestPairs, WithoutLandmarks) {
  const Known& known = GetParam();
  const char* data = std::getenv("KEYPOSE_DATA");
  const std::filesystem::path folder = std::filesystem::path(data ? data : KEYPOSE_SOURCE_DIR "/../shared/data") / "pairs" / known.name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here; set KEYPOSE_DATA";
  const Mesh source = ReadMesh(folder / "source.obj"), target = ReadMesh(folder / "target.obj");
  const std::vector<int> truth = ReadTruth(folder / known.truth, source.vertex_count());
  const bool everywhere = std::count(truth.begin(), truth.end(), -1) < source.vertex_count() / 2;
  const double diagonal = BoundingDiagonal(target.points);
  const auto apart = [&](int a, int b) { return (target.points.row(a) - target.points.row(b)).norm() / diagonal; };
  const std::clock_t start = std::clock();
  const Suggestion found = SuggestLandmarks(source, target, {}, {});
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::vector<double> errors;
  for (std::size_t v = 0; v < truth.size(); ++v)
    if (truth[v] >= 0 && found.dense[v] >= 0) errors.push_back(apart(truth[v], found.dense[v]));
  ASSERT_FALSE(errors.empty());
  std::sort(errors.begin(), errors.end());
  double mean = 0;
  for (const double e : errors) mean += e / static_cast<double>(errors.size());
  int within = 0;
  double worst = 0;
  for (const SuggestedPair& pair : found.pairs) {
    if (!everywhere) break;
    const int s = VertexOf(source, pair.pick.source_face, pair.pick.source_barycentric);
    const double e = apart(NearestTruth(source, truth, s), VertexOf(target, pair.pick.target_face, pair.pick.target_barycentric));
    within += e < 0.05;
    worst = std::max(worst, e);
  }
  std::printf("| %s | %.2f | %d of %zu | %.4f | %.4f | %.4f | %.2f | %.2f |\n", known.name, seconds, within, found.pairs.size(), worst,
              mean, errors[errors.size() * 95 / 100], found.orientation, found.margin);
  EXPECT_LT(mean, known.dense_mean);
  EXPECT_EQ(found.pairs.size(), 12u);
  EXPECT_GE(within, known.suggestions_within_5);
}

INSTANTIATE_TEST_SUITE_P(Data, SuggestPairs,
                         testing::Values(Known{"cat_ref_07", "gt.txt", 0.042, 10}, Known{"cheb_rest_01", "gt.txt", 0.020, 10},
                                         Known{"faust_000_008", "gt.txt", 0.016, 11}, Known{"lps_faust8k_000_018", "gt.txt", 0.020, 11},
                                         Known{"tosca_cat0_cat6", "gt.txt", 0.039, 9}, Known{"wolf_rest_1", "gt.txt", 0.0145, 11},
                                         Known{"horse_to_camel", "landmarks.txt", 0.068, 0}));

}  // namespace
}  // namespace keypose::registration
