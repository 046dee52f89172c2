#include "synth/scores/surface_score.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/surfaces/geometry.h"
#include "synth/scores/score.h"
#include "synth/scores/testing/creature.h"

namespace keypose::synth::surface_score_test {

using Eigen::Vector3d;

TEST(ScoreSurface, ConcentricBallsAreTheDifferenceOfTheirRadiiApart) {
  Mesh inner = BallOf(1), outer = inner;
  outer.points *= 1.03;
  const SurfaceScore score = ScoreSurface(outer, inner);
  const double diagonal = BoundingDiagonal(outer.points);
  EXPECT_NEAR(score.mean_to_truth, 0.03 / diagonal,
              0.0002);  // faces are chords, slightly inside both balls
  EXPECT_NEAR(score.mean_from_truth, 0.03 / diagonal, 0.0002);
  EXPECT_NEAR(score.max_from_truth, 0.03 / diagonal, 0.0002);
}

TEST(ScoreSurface, AMissingPartShowsFromTheTruthOnly) {
  const Mesh ball = BallOf(1);
  Mesh half = ball;
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < ball.faces.rows(); ++f)
    if (ball.points(ball.faces(f, 0), 2) < 0) half.faces.row(kept++) = ball.faces.row(f);
  half.faces.conservativeResize(kept, 3);
  const SurfaceScore score = ScoreSurface(ball, half);
  EXPECT_LT(score.max_to_truth, 1e-12);
  EXPECT_GT(score.max_from_truth, 0.3);
}

TEST(RefineAlignment, UndoesASmallError) {
  const Mesh& truth = Creature().rest;
  const Similarity3 error{
      1.01, Eigen::AngleAxisd(0.02, Vector3d::UnitY()).toRotationMatrix(), {0.001, -0.002, 0.001}};
  Mesh mesh = truth;
  mesh.points = Transformed(error, truth.points);
  const Similarity3 refined = RefineAlignment(truth, mesh, Similarity3{}, 60);
  EXPECT_LT((Transformed(refined, mesh.points) - truth.points).rowwise().norm().mean(), 0.0002);
}

}  // namespace keypose::synth::surface_score_test
