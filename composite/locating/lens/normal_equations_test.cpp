// Derivatives of pixels, and a step by them.
#include <gtest/gtest.h>

#include "composite/locating/lens/normal_equations.h"
#include "composite/locating/testing/odd_body.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite::normal_equations_test {

TEST(PixelDerivatives, AreThoseOfDifferences) {
  Camera camera = TestCamera();
  camera.k1 = -0.2, camera.k2 = 0.05, camera.p1 = 0.01, camera.p2 = -0.02;
  const Eigen::Vector3d x(0.2, -0.15, 0.9);
  const PixelDerivatives d = DerivativesAt(camera, x);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d move = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector2d difference =
        (camera.Project(x + move) - camera.Project(x - move)) / (2 * kStep);
    EXPECT_LT((d.by_point.col(i) - difference).norm(), 1e-5 * camera.fx);
  }
  Camera longer = camera, bent = camera;
  longer.fx *= 1 + kStep, longer.fy *= 1 + kStep, bent.k1 += kStep;
  EXPECT_LT(((longer.Project(x) - camera.Project(x)) / kStep - d.by_log_focal).norm(), 1e-2);
  EXPECT_LT(((bent.Project(x) - camera.Project(x)) / kStep - d.by_k1).norm(), 1e-2);
}

TEST(NormalEquations, OneStepBringsPointsNearlyHome) {
  const PointsX3 corners = MakeBox(0.1, 0.15, 0.2).points;
  const Placement truth = LookingFrom(30, 20), start = Disturbed(truth, 2, 0.003);
  NormalEquations equations(start, corners.colwise().mean().transpose(), 0.15);
  for (Eigen::Index v = 0; v < corners.rows(); ++v) {
    const Eigen::Vector2d off = truth.Project(corners.row(v)) - start.Project(corners.row(v));
    equations.Add(corners.row(v), Eigen::Vector2d::UnitX(), off.x(), 1);
    equations.Add(corners.row(v), Eigen::Vector2d::UnitY(), off.y(), 1);
  }
  const Placement moved = equations.Moved(equations.Solve(FreeUnknowns(false, false), 0));
  EXPECT_LT(ShiftBetween(moved, truth, corners), 0.05 * ShiftBetween(start, truth, corners));
}

}  // namespace keypose::composite::normal_equations_test
