// Suggestions on real pairs with known correspondence. Prints the table of
// docs/results/landmarks.md. Skipped without the data.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <random>
#include <sstream>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/testing/paths.h"
#include "register/intrinsic/suggest.h"

namespace keypose::registration::suggest_pairs_test {

struct Known {
  const char* name;
  const char* truth;         ///< file of lines `source_vertex target_vertex`
  double dense_mean;         ///< bound, over the diagonal; 1.3 times what was measured
  int suggestions_within_5;  ///< of 12, at least; one less than measured
};

class SuggestPairs : public ::testing::TestWithParam<Known> {};

std::vector<int> ReadTruth(const std::filesystem::path& path, int vertices) {
  std::vector<int> truth(static_cast<std::size_t>(vertices), -1);
  std::istringstream in(ReadFile(path));
  for (int s = 0, t = 0; in >> s >> t;) truth[s] = t;
  return truth;
}

int VertexOf(const Mesh& mesh, int face, const Eigen::Vector3d& barycentric) {
  Eigen::Index k = 0;
  barycentric.maxCoeff(&k);
  return mesh.faces(face, k);
}

/// The true target vertex of the nearest vertex that has one.
int NearestTruth(const Mesh& source, const std::vector<int>& truth, int vertex) {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const double d = (source.points.row(v) - source.points.row(vertex)).squaredNorm();
    if (truth[v] >= 0 && d < least) least = d, best = truth[v];
  }
  return best;
}

/// Removes the faces whose first corner is lost, which leaves ragged holes, and renumbers the
/// truth.
template <class Lost>
void Cut(Mesh& target, std::vector<int>& truth, const Lost& lost) {
  Mesh rest;
  std::vector<int> kept(static_cast<std::size_t>(target.vertex_count()), -1);
  rest.points.resize(target.points.rows(), 3);
  rest.faces.resize(target.faces.rows(), 3);
  Eigen::Index faces = 0;
  int vertices = 0;
  for (Eigen::Index f = 0; f < target.faces.rows(); ++f) {
    if (lost(target.points.row(target.faces(f, 0)))) continue;
    for (int k = 0; k < 3; ++k) {
      int& id = kept[target.faces(f, k)];
      if (id < 0) rest.points.row(id = vertices++) = target.points.row(target.faces(f, k));
      rest.faces(faces, k) = id;
    }
    ++faces;
  }
  rest.points.conservativeResize(vertices, 3);
  rest.faces.conservativeResize(faces, 3);
  target = rest;
  for (int& t : truth) t = t < 0 ? -1 : kept[t];
}

/// "noise": 0.2 % of the diagonal, near normal; "holes": eight balls of 4 % of the diagonal;
/// "cropped": the lowest tenth of the vertices.
void Damage(const std::string& kind, Mesh& target, std::vector<int>& truth) {
  const double diagonal = BoundingDiagonal(target.points);
  if (kind == "noise") {
    std::mt19937_64 random(7);
    for (Eigen::Index i = 0; i < target.points.size(); ++i) {
      double sum = -6;
      for (int k = 0; k < 12; ++k) sum += static_cast<double>(random() >> 11) * 0x1.0p-53;
      target.points.data()[i] += 0.002 * diagonal * sum;
    }
  } else if (kind == "holes") {
    std::vector<Eigen::RowVector3d> centers;
    for (long i = 0; i < 8; ++i)
      centers.push_back(target.points.row((i * 7919 + 1234) % target.points.rows()));
    Cut(target, truth, [&](const Eigen::RowVector3d& p) {
      return std::any_of(centers.begin(), centers.end(),
                         [&](const auto& c) { return (c - p).norm() < 0.04 * diagonal; });
    });
  } else {
    const double lowest = QuantileAbove(Eigen::VectorXd(target.points.col(1)), 0.1);
    Cut(target, truth, [&](const Eigen::RowVector3d& p) { return p.y() < lowest; });
  }
}

TEST_P(SuggestPairs, OnDamagedTargets) {
  const Known& known = GetParam();
  const std::filesystem::path folder = DataFolder() / "pairs" / known.name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here; set KEYPOSE_DATA";
  const Mesh source = ReadMesh(folder / "source.obj");
  std::printf("| %s |", known.name);
  for (const std::string kind : {"noise", "holes", "cropped"}) {
    Mesh target = ReadMesh(folder / "target.obj");
    const double diagonal = BoundingDiagonal(target.points);
    std::vector<int> truth = ReadTruth(folder / known.truth, source.vertex_count());
    Damage(kind, target, truth);
    const Suggestion found = SuggestLandmarks(source, target, {}, {});
    double sum = 0;
    int count = 0;
    for (std::size_t v = 0; v < truth.size(); ++v)
      if (truth[v] >= 0 && found.dense[v] >= 0)
        sum += (target.points.row(truth[v]) - target.points.row(found.dense[v])).norm(), ++count;
    ASSERT_GT(count, 0);
    std::printf(" %.4f (%.2f) |", sum / count / diagonal, found.orientation);
    // A mirrored or back-to-front map is wrong by 0.15 or more. This happens for people without
    // feet, but then much of the surface is turned over.
    if (found.orientation >= 0.85) {
      EXPECT_LT(sum / count / diagonal, std::string(known.name) == "horse_to_camel" ? 0.13 : 0.08)
          << kind;
    }
  }
  std::printf("\n");
}

TEST_P(SuggestPairs, WithoutLandmarks) {
  const Known& known = GetParam();
  const std::filesystem::path folder = DataFolder() / "pairs" / known.name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here; set KEYPOSE_DATA";
  const Mesh source = ReadMesh(folder / "source.obj"), target = ReadMesh(folder / "target.obj");
  const std::vector<int> truth = ReadTruth(folder / known.truth, source.vertex_count());
  const bool everywhere = std::count(truth.begin(), truth.end(), -1) < source.vertex_count() / 2;
  const double diagonal = BoundingDiagonal(target.points);
  const auto apart = [&](int a, int b) {
    return (target.points.row(a) - target.points.row(b)).norm() / diagonal;
  };
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
    const double e = apart(NearestTruth(source, truth, s),
                           VertexOf(target, pair.pick.target_face, pair.pick.target_barycentric));
    within += e < 0.05;
    worst = std::max(worst, e);
  }
  std::printf("| %s | %.2f | %d of %zu | %.4f | %.4f | %.4f | %.2f | %.2f |\n", known.name, seconds,
              within, found.pairs.size(), worst, mean, errors[errors.size() * 95 / 100],
              found.orientation, found.margin);
  EXPECT_LT(mean, known.dense_mean);
  EXPECT_EQ(found.pairs.size(), 12u);
  EXPECT_GE(within, known.suggestions_within_5);
}

INSTANTIATE_TEST_SUITE_P(Data, SuggestPairs,
                         ::testing::Values(Known{"cat_ref_07", "gt.txt", 0.042, 10},
                                         Known{"cheb_rest_01", "gt.txt", 0.020, 10},
                                         Known{"faust_000_008", "gt.txt", 0.016, 11},
                                         Known{"lps_faust8k_000_018", "gt.txt", 0.020, 11},
                                         Known{"tosca_cat0_cat6", "gt.txt", 0.039, 9},
                                         Known{"wolf_rest_1", "gt.txt", 0.0145, 11},
                                         Known{"horse_to_camel", "landmarks.txt", 0.068, 0}));

}  // namespace keypose::registration::suggest_pairs_test
