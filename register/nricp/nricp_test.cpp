#include "register/nricp/nricp.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "register/nricp/testing/bumpy_ball.h"
#include "register/testing/scenes.h"

namespace keypose::registration::nricp_test {

TEST(RegisterNricp, MeshOntoItselfIsLeftAloneInOneSolveARound) {
  const Mesh mesh = Bumpy(3);
  const NricpOptions options;
  const NricpResult result = RegisterNricp(mesh, mesh, Every(60, mesh.points), {}, options);
  EXPECT_EQ(result.iterations, options.alpha_steps);
  EXPECT_LT((result.points - mesh.points).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(result.alignment.method, "procrustes");
}

TEST(RegisterNricp, TranslatingBothMeshesTranslatesTheResult) {
  const Mesh source = MakeIcosphere(2);
  Mesh target = Bumpy(3);
  const auto goals = [&](const Eigen::RowVector3d& shift) {
    std::vector<LandmarkGoal> list;
    for (int i = 0; i < 42; i += 4) list.push_back(At(i, target.points.row(i) + shift));
    return list;
  };
  NricpOptions options;
  options.alpha_min = 1;
  // conjugate gradients stop at a tolerance, so rounding would change the result
  options.exact_solves = true;
  const PointsX3 before = RegisterNricp(source, target, goals({0, 0, 0}), {}, options).points;
  const Eigen::RowVector3d shift(3, -2, 5);
  Mesh moved_source = source, moved_target = target;
  moved_source.points.rowwise() += shift;
  moved_target.points.rowwise() += shift;
  const PointsX3 after =
      RegisterNricp(moved_source, moved_target, goals(shift), {}, options).points;
  EXPECT_LT((after - (before.rowwise() + shift)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(RegisterNricp, AnalysesOnceAndRefactorsSeldom) {
  const Mesh source = MakeIcosphere(3);
  const NricpResult result = RegisterNricp(source, Bumpy(3), {}, {}, {});
  EXPECT_EQ(result.analyses, 1);
  EXPECT_LT(result.factorisations, result.iterations);
  NricpOptions exact;
  exact.exact_solves = true;
  EXPECT_EQ(RegisterNricp(source, Bumpy(3), {}, {}, exact).analyses, 1);
}

TEST(RegisterNricp, ConjugateGradientsChangeNothingThatMatters) {
  const Mesh tube = MakeCylinder(0.12, 2, 20, 40), fine = MakeCylinder(0.12, 2, 23, 47);
  Mesh target = fine;
  target.points = Bent(fine.points, 2, 0.7);
  const std::vector<LandmarkGoal> goals = Every(70, Bent(tube.points, 2, 0.7));
  NricpOptions exact;
  exact.exact_solves = true;
  const PointsX3 a = RegisterNricp(tube, target, goals, {}, {}).points,
                 b = RegisterNricp(tube, target, goals, {}, exact).points;
  EXPECT_LT((a - b).rowwise().norm().maxCoeff() / BoundingDiagonal(target.points),
            1e-3);  // the effect of one inner loop more or less
}

TEST(RegisterNricp, SameBitsAtOneAndTwoThreads) {
  const Mesh source = MakeIcosphere(3), target = Bumpy(3);
  SetThreadCount(1);
  const PointsX3 one = RegisterNricp(source, target, {}, {}, {}).points;
  SetThreadCount(2);
  const PointsX3 two = RegisterNricp(source, target, {}, {}, {}).points;
  SetThreadCount(0);
  EXPECT_EQ(one, two);
}

TEST(RegisterNricp, OpenMeshesAndStrayPartsStayFinite) {
  Mesh source = MakeIcosphere(2), target = Bumpy(3);
  target.faces.conservativeResize(target.face_count() / 2, 3);  // half a target, with a boundary
  const int n = source.vertex_count();
  PointsX3 points(2 * n, 3);
  points << source.points, (0.05 * source.points).rowwise() + Eigen::RowVector3d(6, 6, 6);
  FacesX3 faces(2 * source.face_count(), 3);
  faces << source.faces, (source.faces.array() + n).matrix();
  source.points = points;
  source.faces = faces;
  const NricpResult result = RegisterNricp(source, target, Every(20, Bumpy(2).points), {}, {});
  EXPECT_TRUE(result.points.allFinite());
  EXPECT_LT(result.kept, 1);
}

TEST(RegisterNricp, StiffPartsBendLess) {
  const Mesh tube = MakeCylinder(0.12, 2, 16, 30);
  Mesh target = tube;
  target.points = Bent(tube.points, 2, 0.6);
  Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(tube.vertex_count());
  for (int i = 0; i < tube.vertex_count(); ++i)
    if (tube.points(i, 2) < 1) stiffness[i] = 30;
  const auto bending =
      [&](const PointsX3& p) {  // how far the motion of the lower half is from one affine map
        std::vector<int> low;
        for (int i = 0; i < tube.vertex_count(); ++i)
          if (tube.points(i, 2) < 0.9) low.push_back(i);
        Eigen::MatrixXd before(low.size(), 4), after(low.size(), 3);
        before << tube.points(low, Eigen::all), Eigen::VectorXd::Ones(low.size());
        after = p(low, Eigen::all);
        return (before * before.colPivHouseholderQr().solve(after) - after).norm();
      };
  NricpOptions options;
  options.alpha_min = 1;
  const std::vector<LandmarkGoal> goals = Every(50, target.points);
  const PointsX3 plain = RegisterNricp(tube, target, goals, {}, options).points,
                 held = RegisterNricp(tube, target, goals, stiffness, options).points;
  EXPECT_LT(bending(held), 0.5 * bending(plain));
}

TEST(RegisterNricp, BadMeshesThrowInputError) {
  const Mesh good = MakeIcosphere(1);
  Mesh empty, nan = good, point = good;
  nan.points(3, 1) = std::numeric_limits<double>::quiet_NaN();
  point.points.setConstant(1);
  EXPECT_THROW(RegisterNricp(empty, good, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, empty, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(nan, good, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, nan, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(point, good, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, point, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, good, {At(999, {0, 0, 0})}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, good, {}, Eigen::VectorXd::Zero(good.vertex_count()), {}),
               InputError);
}

}  // namespace keypose::registration::nricp_test
