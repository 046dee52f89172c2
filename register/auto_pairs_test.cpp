// The default method on real pairs with known correspondence, compared with the numbers in
// docs/results/registration.md. Skipped without the data.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/testing/paths.h"
#include "register/auto/auto_registration.h"
#include "register/landmarks/landmarks.h"
#include "register/quality/flipped_faces.h"

namespace keypose::registration::auto_pairs_test {

namespace fs = std::filesystem;

constexpr std::size_t kLandmarks = 12;
// Results differ slightly between processors, because their linear algebra rounds differently.
constexpr double kTolerance = 1.2;

struct Figures {
  double mean_error = 0;  ///< over the target's diagonal
  int flipped = 0;        ///< faces that oppose the target's nearest face
  int flipped_true = -1;  ///< faces that oppose themselves at their true places; -1: not known
};

std::ostream& operator<<(std::ostream& out, const Figures& figures) {
  return out << "mean error " << figures.mean_error << ", flipped " << figures.flipped
             << ", by the truth " << figures.flipped_true;
}

std::vector<std::string> Cells(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream words(row);
  for (std::string cell; std::getline(words, cell, '|');) cells.push_back(cell);
  return cells;
}

/// The cells of all rows about the pair, in the page's order: with 12 landmarks, without, and what
/// more is said of keypose auto.
std::vector<std::vector<std::string>> RowsAbout(const std::string& pair) {
  std::istringstream page(ReadFile(SourceFolder() + "/docs/results/registration.md"));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(page, line);)
    if (line.starts_with("| " + pair + " |")) rows.push_back(Cells(line));
  return rows;
}

/// | pair | mean, 95 %, flipped, CPU s of keypose auto | ... and | pair | largest | Hausdorff |
/// true |
/// ... with a semicolon between the figures with landmarks and without.
Figures DocumentedFigures(const std::string& pair) {
  const auto rows = RowsAbout(pair);
  Figures figures;
  std::istringstream with_landmarks(rows.empty() ? "" : rows[0].at(2));
  double at_95 = 0;
  char comma = 0;
  with_landmarks >> figures.mean_error >> comma >> at_95 >> comma >> figures.flipped;
  if (!with_landmarks || rows.size() < 3)
    ADD_FAILURE() << "docs/results/registration.md has not its three rows about " << pair;
  else if (std::istringstream flipped_true(rows[2].at(4)); !(flipped_true >> figures.flipped_true))
    figures.flipped_true = -1;
  return figures;
}

struct Truth {
  std::vector<int> vertices;  ///< source vertices whose true position is known
  PointsX3 places;            ///< their true positions
};

Truth ReadTruth(const fs::path& file, const Mesh& target) {
  std::istringstream lines(ReadFile(file));
  std::vector<int> vertices, on_target;
  for (int source = 0, match = 0; lines >> source >> match;) {
    vertices.push_back(source);
    on_target.push_back(match);
  }
  return {vertices, target.points(on_target, Eigen::all)};
}

Figures Measure(const Mesh& source, const PointsX3& registered, const Mesh& target,
                const Truth& truth) {
  Figures measured;
  const PointsX3 ours = registered(truth.vertices, Eigen::all);
  measured.mean_error =
      (ours - truth.places).rowwise().norm().mean() / BoundingDiagonal(target.points);
  const std::vector<char> opposed =
      TargetFaces(target.points, target.faces).Opposed(registered, source.faces, 0);
  measured.flipped = static_cast<int>(std::count(opposed.begin(), opposed.end(), 1));
  // If the position of a corner is not known, the comparison below is with NaN, so it is false.
  PointsX3 places = PointsX3::Constant(source.vertex_count(), 3, std::nan(""));
  places(truth.vertices, Eigen::all) = truth.places;
  const PointsX3 normals = FaceNormals(registered, source.faces),
                 true_normals = FaceNormals(places, source.faces);
  measured.flipped_true =
      static_cast<int>((normals.cwiseProduct(true_normals).rowwise().sum().array() < 0).count());
  return measured;
}

class RealPair : public ::testing::TestWithParam<const char*> {};

TEST_P(RealPair, IsRegisteredAsWellAsDocumented) {
  const fs::path folder = DataFolder() / "pairs" / GetParam();
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not here; set KEYPOSE_DATA";
  const Mesh source = ReadMesh(folder / "source.obj"), target = ReadMesh(folder / "target.obj");
  std::vector<PickedPair> picked;
  for (const LandmarkPair& p : ReadLandmarkPairs({folder / "landmarks.txt"}, source, target))
    if (picked.size() < kLandmarks)
      picked.push_back(
          {p.name, p.source.face, p.target.face, p.source.barycentric, p.target.barycentric});
  ASSERT_EQ(picked.size(), kLandmarks);
  const AutoResult result =
      RegisterAuto(source, target, CheckLandmarks(picked, source, target).goals, {}, {});
  const Figures documented = DocumentedFigures(GetParam()),
                measured =
                    Measure(source, result.points, target, ReadTruth(folder / "gt.txt", target));
  SCOPED_TRACE(::testing::Message() << "measured: " << measured << "; documented: " << documented);
  EXPECT_LE(measured.mean_error, kTolerance * documented.mean_error);
  EXPECT_LE(measured.flipped, kTolerance * documented.flipped);
  if (documented.flipped_true >= 0) {
    EXPECT_LE(measured.flipped_true, kTolerance * documented.flipped_true);
  }
}

INSTANTIATE_TEST_SUITE_P(Data, RealPair,
                         ::testing::Values("cheb_rest_01", "faust_000_008", "wolf_rest_1"));

}  // namespace keypose::registration::auto_pairs_test
