#include "reconstruct/refinement/displacement_solve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"

namespace keypose::reconstruct::displacement_solve_test {

TEST(SolveDisplacement, StrongDataAreMet) {
  const Mesh ball = MakeIcosphere(3);
  const Neighbors neighbors = MakeNeighbors(ball.points, ball.faces);
  DisplacementEnergy energy{neighbors.mean_edge, 0.02, 1, 1e-4, {}, {}, {}, {}};
  energy.target.assign(ball.vertex_count(), 0.7f), energy.weight.assign(ball.vertex_count(), 1e4f);
  std::vector<float> shift(ball.vertex_count(), 0.0f);
  SolveDisplacement(ball.points, ball.points, neighbors, energy, &shift);
  for (const float d : shift) EXPECT_NEAR(d, 0.7f, 1e-3f);
}

TEST(SolveDisplacement, WithoutDataNoiseIsSmoothedAway) {
  Mesh ball = MakeIcosphere(4);
  const Neighbors neighbors = MakeNeighbors(ball.points, ball.faces);
  const PointsX3 normals = ball.points;
  for (int v = 0; v < ball.vertex_count(); ++v)
    ball.points.row(v) *= 1 + 0.01 * std::sin(12.9898 * v);
  DisplacementEnergy energy{neighbors.mean_edge, 0.02, 10, 1e-4, {}, {}, {}, {}};
  energy.target.assign(ball.vertex_count(), 0.0f), energy.weight.assign(ball.vertex_count(), 0.0f);
  std::vector<float> shift(ball.vertex_count(), 0.0f);
  SolveDisplacement(ball.points, normals, neighbors, energy, &shift);
  double before = 0, after = 0;
  for (int v = 0; v < ball.vertex_count(); ++v) {
    before += std::pow(ball.points.row(v).norm() - 1, 2);
    after += std::pow(
        (ball.points.row(v) + shift[v] * neighbors.mean_edge * normals.row(v)).norm() - 1, 2);
  }
  EXPECT_LT(after, 0.25 * before);
}

TEST(Diffuse, VerticesThatKnowNothingTakeFromTheOthers) {
  const Mesh ball = MakeIcosphere(2);
  const Neighbors neighbors = MakeNeighbors(ball.points, ball.faces);
  std::vector<char> known(ball.vertex_count(), 1);
  std::vector<float> values(ball.vertex_count(), 3.0f);
  known[5] = 0, values[5] = 100;
  Diffuse(neighbors, 1, 1, known, &values);
  for (const float value : values) EXPECT_NEAR(value, 3, 1e-5f);
}

}  // namespace keypose::reconstruct::displacement_solve_test
