// Suggestions on a four-legged body with known truth, and the functions behind them.
#include "register/intrinsic/suggest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numeric>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/files.h"
#include "core/io/landmarks_io.h"
#include "core/io/mesh_io.h"
#include "core/parallel.h"
#include "core/testing_shapes.h"
#include "deform/levels/geodesics.h"
#include "register/intrinsic/functional_map.h"
#include "register/intrinsic/spectral.h"
#include "register/intrinsic/tip_matching.h"
#include "register/landmarks/landmark_picture.h"

namespace keypose::registration {
namespace {

struct Limb {
  Eigen::Vector3d toward;
  double length;
};

/// A ball with limbs: a sphere whose points are moved outwards. `turn` rotates the tessellation,
/// not the shape.
Mesh LimbedBody(const std::vector<Limb>& limbs, int levels,
                const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
  Mesh mesh = MakeIcosphere(levels);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d direction = (turn * mesh.points.row(v).transpose()).normalized();
    double radius = 0.4;
    for (const Limb& limb : limbs)
      radius += limb.length * std::exp(18 * (direction.dot(limb.toward.normalized()) - 1));
    mesh.points.row(v) = radius * direction.transpose();
  }
  return mesh;
}

/// Left and right are equal, head and tail are not; legs are below.
const std::vector<Limb> kQuadruped = {{{0, 1, 0.5}, 0.9},       {{0, -1, 0.2}, 1.2},
                                      {{0.6, 0.6, -0.7}, 0.8},  {{-0.6, 0.6, -0.7}, 0.8},
                                      {{0.6, -0.6, -0.7}, 0.7}, {{-0.6, -0.6, -0.7}, 0.7}};
/// Rotationally symmetric: only a person can say which arm is which.
const std::vector<Limb> kStar = {
    {{1, 0, 0}, 0.9}, {{0, 1, 0}, 0.9}, {{-1, 0, 0}, 0.9}, {{0, -1, 0}, 0.9}, {{0, 0, 1}, 0.5}};

/// Bends the spine sideways and down, then rotates and scales the whole.
Mesh Posed(const Mesh& mesh) {
  Mesh posed = mesh;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d p = mesh.points.row(v);
    const Eigen::Matrix3d bend = (Eigen::AngleAxisd(0.5 * p.y(), Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(0.4 * p.y(), Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
    posed.points.row(v) = (7 * (turn * (bend * p)) + Eigen::Vector3d(3, 4, 5)).transpose();
  }
  return posed;
}

Eigen::Matrix3d OtherTessellation() {
  return Eigen::AngleAxisd(0.37, Eigen::Vector3d(3, 1, 2).normalized()).toRotationMatrix();
}

/// Distance at rest between each vertex and the one it is mapped to, over the diagonal.
double MeanError(const Mesh& source_rest, const Mesh& target_rest, const std::vector<int>& dense) {
  double sum = 0;
  for (std::size_t v = 0; v < dense.size(); ++v)
    sum += (source_rest.points.row(v) - target_rest.points.row(dense[v])).norm();
  return sum / (static_cast<double>(dense.size()) * BoundingDiagonal(source_rest.points));
}

Eigen::Vector3d At(const Mesh& mesh, int face, const Eigen::Vector3d& barycentric) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    p += barycentric[k] * mesh.points.row(mesh.faces(face, k)).transpose();
  return p;
}

TEST(SuggestLandmarks, FindsTheSamePlacesOfABentBodyOfOtherTessellation) {
  const Mesh source = LimbedBody(kQuadruped, 4),
             target_rest = LimbedBody(kQuadruped, 4, OtherTessellation());
  const Suggestion found = SuggestLandmarks(source, Posed(target_rest), {}, {});
  const double diagonal = BoundingDiagonal(source.points);
  // A mirror image would be wrong by half the body's width on average: 0.1 of the diagonal or more.
  EXPECT_LT(MeanError(source, target_rest, found.dense), 0.025);
  EXPECT_GT(found.orientation, 0.9);
  EXPECT_GT(found.margin, 0.05);
  ASSERT_EQ(found.pairs.size(), 12u);
  int near = 0, tips = 0;
  for (const SuggestedPair& pair : found.pairs) {
    const Eigen::Vector3d p = At(source, pair.pick.source_face, pair.pick.source_barycentric);
    near += (p - At(target_rest, pair.pick.target_face, pair.pick.target_barycentric)).norm() <
            0.05 * diagonal;
    tips += pair.origin == "tip";
    EXPECT_GE(pair.confidence, 0.4);
    EXPECT_LE(pair.confidence, 1);
  }
  EXPECT_GE(near, 11);
  EXPECT_GE(tips, 3);
  EXPECT_THAT(found.explanation, testing::HasSubstr("6 on the source"));
}

TEST(SuggestLandmarks, TargetTheOtherWayRoundIsNotTakenForAMirrorImage) {
  // The target is the mirror image of the body, so the true point map would turn every face over.
  // The map that is found must keep the orientation instead.
  const Mesh source = LimbedBody(kQuadruped, 4);
  Mesh mirrored = LimbedBody(kQuadruped, 4, OtherTessellation());
  mirrored.points.col(0) *= -1;
  mirrored.faces.col(1).swap(mirrored.faces.col(2));
  const Suggestion found = SuggestLandmarks(source, Posed(mirrored), {}, {});
  EXPECT_GT(found.orientation, 0.9);
  EXPECT_LT(MeanError(source, mirrored, found.dense),
            0.025);  // the body is symmetric: its mirror image is itself
}

TEST(SuggestLandmarks, OneKnownPairSettlesWhichArmOfAStarIsWhich) {
  const Mesh source = LimbedBody(kStar, 4);
  // The known pair rotates the star by a quarter turn: arm +x is the target's arm +y.
  Eigen::Index arm_x = 0, arm_y = 0;
  source.points.col(0).maxCoeff(&arm_x);
  source.points.col(1).maxCoeff(&arm_y);
  LandmarkGoal known;
  known.name = "red arm";
  known.source.vertices = Eigen::Vector3i::Constant(static_cast<int>(arm_x));
  known.target = source.points.row(arm_y).transpose();
  const Suggestion found = SuggestLandmarks(source, source, {known}, {});
  Mesh turned = source;  // where each point should land
  turned.points.col(0) = -source.points.col(1);
  turned.points.col(1) = source.points.col(0);
  EXPECT_LT(MeanError(turned, source, found.dense), 0.03);
  for (const SuggestedPair& pair : found.pairs)
    EXPECT_GT((At(source, pair.pick.source_face, pair.pick.source_barycentric) -
               source.points.row(arm_x).transpose())
                  .norm(),
              0.05)
        << pair.pick.name << " repeats the known pair";
}

TEST(SuggestLandmarks, ColoursTellApartWhatHasTheSameShape) {
  Mesh source = LimbedBody(kStar, 4), target = LimbedBody(kStar, 4, OtherTessellation());
  source.colors.resize(source.points.rows(), 3);
  target.colors.resize(target.points.rows(), 3);
  const auto paint = [](const Eigen::RowVector3d& p, double arm_x, double arm_y) {
    // from the red arm on
    const double angle = std::atan2(p.y(), p.x()) - std::atan2(arm_y, arm_x);
    return Eigen::RowVector3d(127 + 120 * std::cos(angle), 127 + 120 * std::sin(angle), 90)
        .cast<std::uint8_t>()
        .eval();
  };
  for (Eigen::Index v = 0; v < source.points.rows(); ++v) {
    source.colors.row(v) = paint(source.points.row(v), 1, 0);
    target.colors.row(v) = paint(target.points.row(v), 0, 1);
  }
  Mesh turned = source;
  turned.points.col(0) = -source.points.col(1);
  turned.points.col(1) = source.points.col(0);
  EXPECT_LT(MeanError(turned, target, SuggestLandmarks(source, target, {}, {}).dense), 0.03);
}

TEST(SuggestLandmarks, SmallPiecesAreLeftOutOfTheMap) {
  const Mesh source = LimbedBody(kQuadruped, 4);
  Mesh target = Posed(source);
  const Mesh eye = MakeIcosphere(1);
  const Eigen::Index body = target.points.rows(), faces = target.faces.rows();
  target.points.conservativeResize(body + eye.points.rows(), 3);
  target.points.bottomRows(eye.points.rows()) =
      (0.2 * eye.points).rowwise() + Eigen::RowVector3d(3, 4, 5);
  target.faces.conservativeResize(faces + eye.faces.rows(), 3);
  target.faces.bottomRows(eye.faces.rows()) = eye.faces.array() + static_cast<int>(body);
  const Suggestion found = SuggestLandmarks(source, target, {}, {});
  EXPECT_LT(*std::max_element(found.dense.begin(), found.dense.end()), body);
  const Suggestion back = SuggestLandmarks(target, source, {}, {});
  for (std::size_t v = static_cast<std::size_t>(body); v < back.dense.size(); ++v) {
    EXPECT_EQ(back.dense[v], -1);
    EXPECT_EQ(back.confidence[static_cast<Eigen::Index>(v)], 0);
  }
}

TEST(SuggestLandmarks, GivesTheSameBitsForAnyThreadCount) {
  const Mesh source = LimbedBody(kQuadruped, 3),
             target = Posed(LimbedBody(kQuadruped, 3, OtherTessellation()));
  SetThreadCount(1);
  const Suggestion one = SuggestLandmarks(source, target, {}, {});
  SetThreadCount(3);
  const Suggestion three = SuggestLandmarks(source, target, {}, {});
  SetThreadCount(0);
  EXPECT_EQ(one.dense, three.dense);
  EXPECT_EQ(one.confidence, three.confidence);
  EXPECT_EQ(one.margin, three.margin);
  ASSERT_EQ(one.pairs.size(), three.pairs.size());
  for (std::size_t k = 0; k < one.pairs.size(); ++k)
    EXPECT_EQ(one.pairs[k].pick.target_face, three.pairs[k].pick.target_face);
}

TEST(SuggestLandmarks, TinyAndFlatMeshesGiveFiniteNumbers) {
  const Mesh ball = MakeIcosphere(1), box = MakeBox(1, 2, 3);
  for (const auto& [a, b] : {std::pair(ball, box), std::pair(box, ball), std::pair(box, box)}) {
    const Suggestion found = SuggestLandmarks(a, b, {}, {});
    EXPECT_TRUE(found.confidence.allFinite());
    EXPECT_TRUE(std::isfinite(found.distortion) && std::isfinite(found.orientation) &&
                std::isfinite(found.margin));
  }
}

TEST(SuggestLandmarks, NamesWhatIsWrongWithItsInput) {
  const Mesh ball = MakeIcosphere(2);
  Mesh flat = ball;
  flat.points.setZero();
  EXPECT_THROW(SuggestLandmarks(flat, ball, {}, {}), InputError);
  EXPECT_THROW(SuggestLandmarks(ball, Mesh{}, {}, {}), InputError);
  SuggestOptions options;
  options.functions = 5;
  EXPECT_THROW(SuggestLandmarks(ball, ball, {}, options), InputError);
  LandmarkGoal stray;
  stray.name = "stray";
  stray.source.vertices = Eigen::Vector3i::Constant(99999);
  try {
    SuggestLandmarks(ball, ball, {stray}, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("'stray'"));
  }
}

TEST(GeodesicGraph, MeasuresAlongTheSurfaceOfASphere) {
  const Mesh ball = MakeIcosphere(4);
  const Eigen::VectorXd distance = GeodesicGraph(ball.points, ball.faces).From({0});
  for (Eigen::Index v = 0; v < ball.points.rows(); ++v) {
    const double exact =
        std::acos(std::clamp(ball.points.row(0).dot(ball.points.row(v)), -1.0, 1.0));
    EXPECT_GE(distance[v], 0.99 * exact);  // chords are less than 1 % shorter than arcs
    EXPECT_LE(distance[v], 1.06 * exact + 1e-9);
  }
}

TEST(GeodesicGraph, DistancesAreTheLeastToTheLastBitWhereTrianglesDifferAThousandfold) {
  Mesh graded = MakeIcosphere(4);
  for (Eigen::Index v = 0; v < graded.points.rows(); ++v)
    graded.points.row(v) *= std::exp(4 * graded.points(v, 2));
  const GeodesicGraph graph(graded.points, graded.faces, GeodesicGraph::kEdgesOnly);
  const int source = 17;
  const Eigen::VectorXd distance = graph.From({source});
  for (int v = 0; v < graph.size(); ++v) {
    double least = v == source ? 0 : std::numeric_limits<double>::infinity();
    for (const int w : graph.neighbors()[v])
      least = std::min(
          least,
          distance[w] +
              (graded.points.row(std::min(v, w)) - graded.points.row(std::max(v, w))).norm());
    ASSERT_EQ(distance[v], least) << "vertex " << v;
  }
}

TEST(GeodesicGraph, PiecesAreJoinedWhereTheyAreNearest) {
  Mesh two = MakeBox(1, 1, 1);
  const Mesh other = MakeBox(1, 1, 1);
  two.points.conservativeResize(16, 3);
  two.points.bottomRows(8) = other.points.rowwise() + Eigen::RowVector3d(1.5, 0, 0);
  two.faces.conservativeResize(24, 3);
  two.faces.bottomRows(12) = other.faces.array() + 8;
  const GeodesicGraph graph(two.points, two.faces);
  EXPECT_TRUE(graph.From({0}).allFinite());
  EXPECT_NEAR(graph.From({0, 1, 2, 3, 4, 5, 6, 7}).tail(8).minCoeff(), 0.5, 1e-12);
}

TEST(GeodesicGraph, FarthestPointsSpreadOut) {
  const Mesh ball = MakeIcosphere(3);
  const GeodesicGraph graph(ball.points, ball.faces);
  const std::vector<int> points = graph.FarthestPoints(20);
  ASSERT_EQ(points.size(), 20u);
  const Eigen::MatrixXd rows = graph.Rows(points);
  double nearest = 1e9;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < i; ++j) nearest = std::min(nearest, rows(i, points[j]));
  const double farthest = graph.From(points).maxCoeff();
  EXPECT_LE(farthest, nearest + 1e-12);  // the guarantee of farthest point sampling
}

TEST(FindPeaks, OrdersHillsByHowFarOneMustDescend) {
  // A chain with hills 5, 3 and 4 and saddles 1 and 2 between them.
  const Eigen::VectorXd field = (Eigen::VectorXd(7) << 0, 5, 1, 3, 2, 4, 0).finished();
  std::vector<std::vector<int>> chain(7);
  for (int i = 0; i + 1 < 7; ++i)
    chain[i].push_back(i + 1), chain[static_cast<std::size_t>(i) + 1].push_back(i);
  const std::vector<Peak> peaks = FindPeaks(chain, field);
  ASSERT_EQ(peaks.size(), 3u);
  EXPECT_EQ(peaks[0].vertex, 1);
  EXPECT_EQ(peaks[0].persistence, 5);
  EXPECT_EQ(peaks[1].vertex, 5);
  EXPECT_EQ(peaks[1].persistence, 3);
  EXPECT_EQ(peaks[2].vertex, 3);
  EXPECT_EQ(peaks[2].persistence, 1);
}

TEST(LaplaceSpectrum, OfASphereIsThatOfTheTextbook) {
  Mesh ball = MakeIcosphere(4);
  ball.points *= 17;
  const Spectrum spectrum = LaplaceSpectrum(ball.points, ball.faces, 25);
  int k = 0;
  for (int degree = 0; degree < 4; ++degree)
    for (int order = -degree; order <= degree; ++order, ++k)
      EXPECT_NEAR(spectrum.values[k], 4 * std::acos(-1.0) * degree * (degree + 1),
                  0.01 * 4 * std::acos(-1.0) * 12)
          << "function " << k;
  const Eigen::MatrixXd gram =
      spectrum.functions.transpose() * spectrum.areas.asDiagonal() * spectrum.functions;
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(25, 25)).cwiseAbs().maxCoeff(), 1e-9);
}

/// Small integers, so that products are exact and there are many ties.
Eigen::MatrixXf WholeNumbers(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  Eigen::MatrixXf numbers(rows, columns);
  for (Eigen::Index i = 0; i < numbers.size(); ++i)
    numbers.data()[i] = static_cast<float>((seed = seed * 1664525u + 1013904223u) >> 29);
  return numbers;
}

TEST(NearestRows, AreThoseOfAllDistancesAndTheFirstOfEquals) {
  for (const Eigen::Index rows : {1, 7, 130, 300}) {
    const Eigen::MatrixXf a = WholeNumbers(rows, 3, 1), b = WholeNumbers(260, 3, 2);
    const PointMaps maps = NearestRows(a, b);
    const auto expect_nearest = [](const Eigen::MatrixXf& from, const Eigen::MatrixXf& to,
                                   const std::vector<int>& map) {
      for (Eigen::Index i = 0; i < from.rows(); ++i) {
        Eigen::Index nearest = 0;
        (to.rowwise() - from.row(i)).rowwise().squaredNorm().minCoeff(&nearest);
        ASSERT_EQ(map[i], nearest) << "row " << i << " of " << from.rows();
      }
    };
    expect_nearest(a, b, maps.forward);
    expect_nearest(b, a, maps.backward);
  }
}

TEST(NearestRows, GiveRowsThatExistEvenWhereNothingIsANumber) {
  Eigen::MatrixXf a = WholeNumbers(150, 4, 3), b = WholeNumbers(90, 4, 4);
  a.row(140).setConstant(std::numeric_limits<float>::quiet_NaN());
  b.row(5).setConstant(std::numeric_limits<float>::infinity());
  for (int all = 0; all < 2; ++all) {
    const PointMaps maps = NearestRows(a, b);
    EXPECT_THAT(maps.forward, testing::Each(testing::AllOf(testing::Ge(0), testing::Lt(90))));
    EXPECT_THAT(maps.backward, testing::Each(testing::AllOf(testing::Ge(0), testing::Lt(150))));
    a.setConstant(std::numeric_limits<float>::quiet_NaN());
  }
}

TEST(RefineMaps, ReturnsToTheIdentityFromACoarseStart) {
  const Mesh body = LimbedBody(kQuadruped, 3);
  const Spectrum spectrum = LaplaceSpectrum(body.points, body.faces, 60);
  const SpectralPoints points{spectrum.functions.cast<float>(), spectrum.areas.cast<float>()};
  const GeodesicGraph graph(body.points, body.faces);
  const std::vector<int> seeds = graph.FarthestPoints(60);
  std::vector<int> nearest;
  graph.From(seeds, &nearest);
  PointMaps start;
  for (const int s : nearest) start.forward.push_back(seeds[s]);
  start.backward = start.forward;
  const PointMaps refined = RefineMaps(points, points, start, {10, 15, 20, 30, 40, 50, 60});
  int exact = 0;
  for (std::size_t v = 0; v < refined.forward.size(); ++v)
    exact += refined.forward[v] == static_cast<int>(v);
  EXPECT_GT(exact, 0.95 * static_cast<double>(refined.forward.size()));
}

TEST(MatchTips, FindsThePermutationAndKeepsWhatIsKnown) {
  const int n = 6;
  Eigen::MatrixXd places(n, 2);
  places << 0, 0, 1, 0.1, 2.2, 0.9, 0.4, 1.7, 3.1, 2.0, 1.5, 3.3;
  const std::vector<int> shuffled = {3, 0, 5, 1, 4, 2};  // source tip i is target tip shuffled[i]
  TipProblem problem;
  problem.source_distances.resize(n, n);
  problem.target_distances.resize(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      problem.source_distances(i, j) = (places.row(i) - places.row(j)).norm();
      problem.target_distances(shuffled[i], shuffled[j]) = problem.source_distances(i, j);
    }
  problem.unlike = Eigen::MatrixXd::Zero(n, n);
  const auto best = MatchTips(problem, 5);
  ASSERT_EQ(best.size(), 5u);
  EXPECT_EQ(best[0].target_of, shuffled);
  for (std::size_t k = 1; k < best.size(); ++k) EXPECT_GE(best[k].score, best[k - 1].score);
  problem.known = 2;  // the first two of both belong together, right or wrong
  for (const TipAssignment& assignment : MatchTips(problem, 10)) {
    EXPECT_EQ(assignment.target_of[0], 0);
    EXPECT_EQ(assignment.target_of[1], 1);
  }
}

TEST(MatchTips, LeavesOutATipThatTheOtherDoesNotHave) {
  TipProblem problem;
  const Eigen::Vector4d source(0, 1, 2.5, 9), target(0, 1, 2.5, -40);
  problem.source_distances =
      (source.replicate(1, 4) - source.transpose().replicate(4, 1)).cwiseAbs();
  problem.target_distances =
      (target.replicate(1, 4) - target.transpose().replicate(4, 1)).cwiseAbs();
  problem.unlike = Eigen::MatrixXd::Zero(4, 4);
  EXPECT_EQ(MatchTips(problem, 1)[0].target_of, (std::vector<int>{0, 1, 2, -1}));
}

class LandmarksProgram : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("keypose_landmarks_test_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    WriteMesh(folder_ / "a.ply", source_);
    WriteMesh(folder_ / "b.ply", target_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  int Run(const std::string& arguments) {
    const std::string command = "cd '" + folder_.string() +
                                "' && '" KEYPOSE_BIN_DIR
                                "/keypose-landmarks' suggest --source a.ply --target b.ply " +
                                arguments + " > log.txt 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  Mesh source_ = LimbedBody(kQuadruped, 3),
       target_ = Posed(LimbedBody(kQuadruped, 3, OtherTessellation()));
  std::filesystem::path folder_;
};

TEST_F(LandmarksProgram, WritesPairsToConfirmAndThenTheConfirmedPicks) {
  ASSERT_EQ(Run("--suggested s.json --picture s.png --panel 64"), 0)
      << ReadFile(folder_ / "log.txt");
  const auto pairs = ReadLandmarkPairs({folder_ / "s.json"}, source_, target_);
  ASSERT_EQ(pairs.size(), 12u);
  for (const LandmarkPair& pair : pairs) EXPECT_FALSE(pair.confirmed);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "s.png"));
  ASSERT_EQ(Run("--suggested t.json --accept 1,3-4 --source_picks a.json --target_picks b.json"), 0)
      << ReadFile(folder_ / "log.txt");
  const auto picks = ReadLandmarkPairs({folder_ / "a.json", folder_ / "b.json"}, source_, target_);
  ASSERT_EQ(picks.size(), 3u);
  EXPECT_EQ(picks[1].name, pairs[2].name);
  EXPECT_EQ(picks[1].target.face, pairs[2].target.face);
  ASSERT_EQ(Run("--suggested u.json --landmarks t.json --count 2"), 0)
      << ReadFile(folder_ / "log.txt");
  const auto again = ReadLandmarkPairs({folder_ / "u.json"}, source_, target_);
  EXPECT_EQ(std::count_if(again.begin(), again.end(),
                          [](const LandmarkPair& pair) { return pair.confirmed; }),
            3);
  EXPECT_EQ(again.size(), 5u);
}

TEST_F(LandmarksProgram, ExitCodesAndNoHalfWrittenFiles) {
  EXPECT_EQ(Run("--suggested s.json --accept 1,99"), 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "s.json"));
  EXPECT_EQ(Run("--suggested s.json --source_picks a.json"), 2);
  WriteFileAtomically(folder_ / "b.ply", "ply\nnonsense");
  EXPECT_EQ(Run("--suggested s.json"), 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "s.json"));
}

TEST(DrawLandmarks, ShowsAMarkOnlyWhereItCanBeSeen) {
  const Mesh ball = MakeIcosphere(3);
  LandmarkPictureOptions options;
  options.panel = 120;
  const DrawnPair front{
      {0, -1, 0}, {0, -1, 0}, false};  // visible in the first view, hidden in the third
  const Image8 without = DrawLandmarks(ball, ball, {}, {}, options),
               with = DrawLandmarks(ball, ball, {front}, {}, options);
  ASSERT_EQ(with.data.size(), without.data.size());
  std::vector<int> changed(4, 0);
  for (int y = 0; y < with.height; ++y)
    for (int x = 0; x < with.width; ++x)
      if (!std::equal(with.at(x, y), with.at(x, y) + 3, without.at(x, y)))
        ++changed[std::min(3, 4 * x / with.width)];
  EXPECT_GT(changed[0], 40);
  EXPECT_EQ(changed[2], 0);
  EXPECT_THROW(DrawLandmarks(ball, ball, {}, {1, 2}, options), InputError);
  options.panel = 10;
  EXPECT_THROW(DrawLandmarks(ball, ball, {}, {}, options), InputError);
}

/// Number of pixels in rows [y0, y1) with the colour of the first mark.
int MarkPixels(const Image8& image, int y0, int y1) {
  int count = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t* p = image.at(x, y);
      count += p[0] == 230 && p[1] == 30 && p[2] == 30;
    }
  return count;
}

TEST(DrawLandmarks, APairThatNoSideShowsGetsAColumnOfItsOwnInBothRows) {
  const Mesh ball = MakeIcosphere(3);
  LandmarkPictureOptions options;
  options.panel = 120;
  const Image8 plain = DrawLandmarks(ball, ball, {}, {}, options);
  // On the source it is visible in the first view. On the target it is at the bottom, where no view
  // from above sees it.
  const Image8 image = DrawLandmarks(ball, ball, {{{0, -1, 0}, {0, 0, -1}, false}}, {}, options);
  ASSERT_GT(image.height, plain.height + 200);
  EXPECT_GT(MarkPixels(image, 0, 120), 20);
  EXPECT_EQ(MarkPixels(image, 124, plain.height), 0);
  EXPECT_GT(MarkPixels(image, plain.height + 4, plain.height + 124), 20);
  EXPECT_GT(MarkPixels(image, plain.height + 128, image.height), 20);
}

TEST(DrawLandmarks, MeshesAreInTheirOwnColours) {
  Mesh red = MakeIcosphere(3);
  red.colors = ColorsX3::Zero(red.vertex_count(), 3);
  red.colors.col(0).setConstant(200);
  LandmarkPictureOptions options;
  options.panel = 120;
  const Image8 image = DrawLandmarks(
      red, red, {}, std::vector<int>(static_cast<std::size_t>(red.vertex_count()), 0), options);
  for (const int y : {60, 184})
    EXPECT_GT(image.at(60, y)[0], 3 * image.at(60, y)[1]) << "row at " << y;
}

}  // namespace
}  // namespace keypose::registration
