#include "deform/levels/geodesics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/surfaces/shapes.h"

namespace keypose::geodesics_test {

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

}  // namespace keypose::geodesics_test
