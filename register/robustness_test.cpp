// Defects of real inputs, with known truth: seams, parts that must not bend, incomplete targets.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/seams.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/size_of.h"
#include "deform/arap/rigid_pieces.h"
#include "register/auto/auto_registration.h"
#include "register/quality/registration_quality.h"
#include "register/testing/scenes.h"
#include "register/testing/tubes.h"

namespace keypose::registration::robustness_test {

using Eigen::RowVector3d;
using Eigen::Vector3d;

/// Cuts the mesh where faces of different charts meet. Each chart after the first gets its own
/// vertices, which are appended.
/// @param origin  receives the original vertex of each vertex
template <class ChartOf>
Mesh CutAtCharts(const Mesh& mesh, const ChartOf& chart_of, std::vector<int>& origin) {
  Mesh cut = mesh;
  origin.resize(mesh.vertex_count());
  std::iota(origin.begin(), origin.end(), 0);
  std::map<std::pair<int, int>, int> own;  // vertex and chart -> vertex
  std::vector<int> first(mesh.vertex_count(), -1);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const Eigen::RowVector3i face = mesh.faces.row(f);
    const int chart = chart_of(f, RowVector3d((mesh.points.row(face[0]) + mesh.points.row(face[1]) +
                                               mesh.points.row(face[2])) /
                                              3));
    for (int k = 0; k < 3; ++k) {
      if (first[face[k]] < 0) first[face[k]] = chart;
      if (first[face[k]] == chart) continue;
      const auto [at, is_new] = own.try_emplace({face[k], chart}, SizeOf(origin));
      if (is_new) origin.push_back(face[k]);
      cut.faces(f, k) = at->second;
    }
  }
  cut.points = mesh.points(origin, Eigen::all);
  return cut;
}

/// Eight charts around and along a tube.
int Chart(Eigen::Index, const RowVector3d& centre) {
  return (centre.x() > 0) + 2 * (centre.y() > 0) + 4 * (centre.z() > 0.9);
}

TEST(FindSeams, JoinsEachDoubleOfACutMeshAndNoMore) {
  for (const Mesh& mesh : {Tube(), MakeIcosphere(2), MakeBox(1, 2, 3)}) {
    EXPECT_TRUE(FindSeams(mesh).empty());
    std::vector<int> origin;
    for (const int charts : {2, 5, 1 << 30}) {  // the last: each face is a chart
      const Mesh cut = CutAtCharts(
          mesh,
          [&](Eigen::Index f, const RowVector3d&) { return static_cast<int>(f * 7919 % charts); },
          origin);
      const Seams seams = FindSeams(cut);
      ASSERT_EQ(seams.joined, cut.vertex_count() - mesh.vertex_count());
      EXPECT_EQ(seams.one, origin);
      EXPECT_EQ(WeldedFaces(cut.faces, seams), mesh.faces);
      const WeldedMesh welded = Weld(cut, seams);
      EXPECT_EQ(welded.mesh.points, mesh.points);
      EXPECT_EQ(welded.mesh.faces, mesh.faces);
      EXPECT_EQ(welded.of_input, origin);
    }
  }
}

TEST(FindSeams, LeavesWhatOnlyTouchesApart) {
  const Mesh box = MakeBox(1, 1, 1);
  Mesh two;  // boxes that share a whole side: closed surfaces have no seams
  two.points.resize(16, 3);
  two.points << box.points, box.points.rowwise() + RowVector3d(1, 0, 0);
  two.faces.resize(24, 3);
  two.faces << box.faces, (box.faces.array() + 8).matrix();
  EXPECT_TRUE(FindSeams(two).empty());
  Mesh point;  // two triangles that share a place, but no edge
  point.points.resize(6, 3);
  point.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, -1, 0;
  point.faces.resize(2, 3);
  point.faces << 0, 1, 2, 3, 4, 5;
  EXPECT_TRUE(FindSeams(point).empty());
  Mesh back = point;  // the same triangle twice, with the same orientation: not a continuation
  back.points.bottomRows(3) = back.points.topRows(3).eval();
  EXPECT_TRUE(FindSeams(back).empty());
  Mesh fan = point;  // three sheets along one edge: it is not known which two belong together
  fan.points.conservativeResize(9, 3);
  fan.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1;
  fan.faces.conservativeResize(3, 3);
  fan.faces << 0, 1, 2, 3, 4, 5, 6, 7, 8;
  EXPECT_TRUE(FindSeams(fan).empty());
  fan.faces.conservativeResize(2, 3);
  EXPECT_EQ(FindSeams(fan).joined, 2);
}

TEST(FindSeams, FacesThatShrinkToAnEdgeAreLeftOut) {
  Mesh mesh;  // a strip of two faces with a seam between them, and a third face
  mesh.points.resize(6, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, -1, 0;
  mesh.faces.resize(3, 3);
  mesh.faces << 0, 1, 2, 3, 4, 5, 2, 1, 5;
  EXPECT_EQ(Weld(mesh, FindSeams(mesh)).mesh.face_count(), 3);
  mesh.faces.row(2) << 5, 0, 4;
  ASSERT_EQ(FindSeams(mesh).joined, 2);
  EXPECT_EQ(Weld(mesh, FindSeams(mesh)).mesh.faces, mesh.faces.topRows(2).unaryExpr([](int v) {
    return v == 3 ? 1 : v == 4 ? 0 : v == 5 ? 3 : v;
  }));
}

TEST(RegisterAuto, ACutMeshIsRegisteredAsTheWholeOne) {
  const Mesh source = Tube();
  Mesh target = OtherTube();
  const PointsX3 truth = Bent(source.points, kLength, 1.5);
  target.points = Bent(target.points, kLength, 1.5);
  Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(source.vertex_count());
  for (int v = 0; v < source.vertex_count(); ++v) stiffness[v] = 1 + source.points(v, 2);
  const AutoResult whole = RegisterAuto(source, target, Every(kGoalStride, truth), stiffness, {});
  std::vector<int> origin, of_target;
  const Mesh cut = CutAtCharts(source, Chart, origin);
  ASSERT_GT(cut.vertex_count(), source.vertex_count() + 100);
  std::vector<LandmarkGoal> goals;  // picked on doubled vertices where possible
  for (const LandmarkGoal& goal : Every(kGoalStride, truth)) {
    goals.push_back(goal);
    for (int v = 0; v < cut.vertex_count(); ++v)
      if (origin[v] == goal.source.vertices[0]) goals.back().source.vertices.setConstant(v);
  }
  const Mesh cut_target = CutAtCharts(
      target, [](Eigen::Index f, const RowVector3d&) { return static_cast<int>(f % 3); },
      of_target);
  const AutoResult result = RegisterAuto(cut, cut_target, goals, stiffness(origin), {});
  EXPECT_EQ(result.seam_vertices, cut.vertex_count() - source.vertex_count());
  EXPECT_EQ(result.points, PointsX3(whole.points(origin, Eigen::all)));
  ASSERT_EQ(result.transforms.size(), origin.size());
  for (std::size_t v = 0; v < origin.size(); ++v)
    EXPECT_EQ(result.transforms[v], whole.transforms[origin[v]]);
  Mesh judged = cut;
  judged.faces = WeldedFaces(cut.faces, FindSeams(cut));
  EXPECT_EQ(MeasureRegistration(judged, result.points, cut_target).self_intersections,
            MeasureRegistration(source, whole.points, target).self_intersections);
}

/// A tube whose part above `bend_from` is stretched by `stretch` and bent by `angle`. The rest does
/// not change.
PointsX3 DrawnOut(const PointsX3& points, double bend_from, double stretch, double angle) {
  PointsX3 moved = points;
  const double length = stretch * (kLength - bend_from), radius = length / angle;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double above = points(i, 2) - bend_from;
    if (above <= 0) continue;
    const double a = stretch * above / radius, r = radius - points(i, 0);
    moved.row(i) << radius - r * std::cos(a), points(i, 1), bend_from + r * std::sin(a);
  }
  return moved;
}

/// The largest relative change of length of an edge between marked vertices.
double LargestChange(const FacesX3& faces, const PointsX3& before, const PointsX3& after,
                     const std::vector<char>& marked) {
  double largest = 0;
  for (const auto& [i, j] : UndirectedEdges(faces))
    if (marked[i] && marked[j])
      largest = std::max(largest, std::abs((after.row(i) - after.row(j)).norm() /
                                               (before.row(i) - before.row(j)).norm() -
                                           1));
  return largest;
}

TEST(RigidPieces, AreTheConnectedRegionsPaintedRigidAndTakeTheirShape) {
  const Mesh mesh = Tube();
  Eigen::VectorXd stiffness = Eigen::VectorXd::Constant(mesh.vertex_count(), 5);
  std::vector<int> low, high;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (const double z = mesh.points(v, 2); z < 0.5 || z > 1.6) {
      stiffness[v] = z < 0.5 ? RigidPieces::kFrom : 1e9;
      (z < 0.5 ? low : high).push_back(v);
    }
  const Eigen::VectorXd areas = Eigen::VectorXd::Ones(mesh.vertex_count());
  EXPECT_TRUE(RigidPieces(mesh.faces, {}, areas).empty());
  EXPECT_TRUE(RigidPieces(mesh.faces, stiffness.cwiseMin(99), areas).empty());
  const RigidPieces pieces(mesh.faces, stiffness, areas);
  ASSERT_EQ(pieces.pieces(), (std::vector<std::vector<int>>{low, high}));
  EXPECT_NEAR(pieces.area_share(),
              static_cast<double>(low.size() + high.size()) / mesh.vertex_count(), 1e-12);
  const Eigen::VectorXd held = RigidPieces::Held(stiffness);
  EXPECT_EQ(held.minCoeff(), 1);
  EXPECT_EQ(held.maxCoeff(), 5);
  // Each piece has its own motion and has grown by a tenth. The parts between are arbitrary.
  Similarity3 of_low, of_high;
  of_low.rotation = Eigen::AngleAxisd(0.5, Vector3d::UnitX()).toRotationMatrix();
  of_high.rotation = Eigen::AngleAxisd(2, Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  of_high.translation << 1, -2, 3;
  PointsX3 moved = PointsX3::Zero(mesh.vertex_count(), 3), expected = moved;
  for (const auto& [motion, piece] : {std::pair(of_low, low), std::pair(of_high, high)}) {
    const RowVector3d centre = mesh.points(piece, Eigen::all).colwise().mean();
    for (int v : piece) {
      expected.row(v) = motion * mesh.points.row(v).transpose();
      moved.row(v) = motion * (centre + 1.1 * (mesh.points.row(v) - centre)).transpose();
    }
  }
  std::vector<Eigen::Matrix3d> maps(mesh.vertex_count(), Eigen::Matrix3d::Zero());
  pieces.ShareMaps(mesh.points, moved, maps);
  EXPECT_LT((maps[low.back()] - of_low.rotation).norm(), 1e-9);
  EXPECT_LT((maps[high.front()] - of_high.rotation).norm(), 1e-9);
  EXPECT_EQ(maps[high.front() - 1], Eigen::Matrix3d::Zero().eval());
  EXPECT_NEAR(pieces.Straighten(mesh.points, moved), 1.1, 1e-9);
  EXPECT_LT((moved - expected).rowwise().norm().maxCoeff(), 1e-9);
}

TEST(RegisterAuto, ARegionPaintedRigidKeepsItsEdgesWhileTheRestStretches) {
  const Mesh source = Tube();
  Similarity3 placed;
  placed.rotation = Eigen::AngleAxisd(1.2, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const double stretch : {1.0, 1.3}) {
    const PointsX3 truth = Transformed(placed, DrawnOut(source.points, 0.9, stretch, 1.2));
    Mesh target = OtherTube();
    target.points = Transformed(placed, DrawnOut(target.points, 0.9, stretch, 1.2));
    std::vector<char> painted(source.vertex_count()), above(source.vertex_count());
    Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(source.vertex_count());
    for (int v = 0; v < source.vertex_count(); ++v) {
      painted[v] = source.points(v, 2) < 0.85;
      above[v] = source.points(v, 2) > 1;
      if (painted[v]) stiffness[v] = 1000;
    }
    const AutoResult result =
        RegisterAuto(source, target, Every(kGoalStride, truth), stiffness, {});
    EXPECT_LT(LargestChange(source.faces, source.points, result.points, painted), 0.01) << stretch;
    const Eigen::VectorXd errors =
        (result.points - truth).rowwise().norm() / BoundingDiagonal(truth);
    EXPECT_LT(errors.mean(), 0.005) << stretch;
    EXPECT_LT(errors.maxCoeff(), 0.03) << stretch;
    EXPECT_GT(LargestChange(source.faces, source.points, result.points, above), 0.6 * (stretch - 1))
        << stretch;
  }
}

/// Removes the faces that have a corner with `gone`, and the vertices that are then unused.
template <class Gone>
Mesh Without(const Mesh& mesh, const Gone& gone) {
  std::vector<int> index(mesh.vertex_count(), -1), kept;
  std::vector<Eigen::RowVector3i> faces;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const Eigen::RowVector3i face = mesh.faces.row(f);
    if (gone(face[0]) || gone(face[1]) || gone(face[2])) continue;
    for (int k = 0; k < 3; ++k)
      if (index[face[k]] < 0) {
        index[face[k]] = SizeOf(kept);
        kept.push_back(face[k]);
      }
    faces.emplace_back(index[face[0]], index[face[1]], index[face[2]]);
  }
  Mesh rest;
  rest.points = mesh.points(kept, Eigen::all);
  rest.faces.resize(std::ssize(faces), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) rest.faces.row(f) = faces[f];
  return rest;
}

/// The remaining share of the length of a bent slender target, and the angle of its bend.
class CutTarget : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(CutTarget, KeepsTheScaleOfTheWhole) {
  const double left = std::get<0>(GetParam()), angle = std::get<1>(GetParam());
  const Mesh source = Tube(), rest = OtherTube();
  Similarity3 placed;
  placed.rotation = Eigen::AngleAxisd(2, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  placed.scale = 40;
  const PointsX3 truth = Transformed(placed, Bent(source.points, kLength, angle));
  Mesh target = rest;
  target.points = Transformed(placed, Bent(rest.points, kLength, angle));
  target = Without(target, [&](int v) { return rest.points(v, 2) > left * kLength; });
  std::vector<LandmarkGoal> goals;
  for (const LandmarkGoal& goal : Every(31, truth))
    if (PositionOf(goal.source, source.points).z() < left * kLength - 0.1) goals.push_back(goal);
  const AutoResult result = RegisterAuto(source, target, goals, {}, {});
  EXPECT_NEAR(result.scale / placed.scale, 1, 0.04);
  double seen = 0, count = 0;
  for (int v = 0; v < source.vertex_count(); ++v)
    if (source.points(v, 2) < left * kLength - 0.1)
      seen += (result.points.row(v) - truth.row(v)).norm(), ++count;
  EXPECT_LT(seen / count / BoundingDiagonal(truth), 0.005);
}

INSTANTIATE_TEST_SUITE_P(LeftAndBend, CutTarget,
                         ::testing::Combine(::testing::Values(0.4, 0.8),
                                            ::testing::Values(0.5, 2.5, 4.5)));

/// A sheet of n x m vertices, nearly flat, or bent about one side.
Mesh Sheet(int n, int m, bool bent) {
  Mesh sheet;
  sheet.points.resize(n * m, 3);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const double a = static_cast<double>(i) / (n - 1), b = 1.6 * j / (m - 1);
      if (bent)
        sheet.points.row(i * m + j) << std::sin(1.2 * a) / 1.2, b,
            (1 - std::cos(1.2 * a)) / 1.2 + 0.1 * a * b;
      else
        sheet.points.row(i * m + j) << a, b, 0.2 * a * a + 0.1 * a * b;
    }
  sheet.faces.resize(2 * (n - 1) * (m - 1), 3);
  for (int i = 0, f = 0; i + 1 < n; ++i)
    for (int j = 0; j + 1 < m; ++j) {
      const int v = i * m + j;
      sheet.faces.row(f++) << v, v + m, v + 1;
      sheet.faces.row(f++) << v + 1, v + m, v + m + 1;
    }
  return sheet;
}

class SmallSheet : public ::testing::TestWithParam<std::pair<int, int>> {};

TEST_P(SmallSheet, DoesNotShrinkAwayFromItsRim) {
  const auto [n, m] = GetParam();
  const Mesh source = Sheet(n, m, false);
  Mesh target = Sheet(n, m, true);
  Similarity3 placed;
  placed.rotation = Eigen::AngleAxisd(1, Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  target.points = Transformed(placed, target.points);
  const AutoResult result = RegisterAuto(source, target, {}, {}, {});
  const Eigen::VectorXd errors =
      (result.points - target.points).rowwise().norm() / BoundingDiagonal(target.points);
  EXPECT_LT(errors.mean(), 0.006);
  EXPECT_LT(errors.maxCoeff(), 0.015);
}

INSTANTIATE_TEST_SUITE_P(Sizes, SmallSheet,
                         ::testing::Values(std::pair(3, 3), std::pair(4, 5), std::pair(6, 9)));

}  // namespace keypose::registration::robustness_test
