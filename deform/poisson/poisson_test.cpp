#include "deform/poisson/poisson.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::poisson_test {

/// The edges of the mesh itself after one linear map.
EdgeBatch Mapped(const Mesh& mesh, const Eigen::Matrix3d& map) {
  EdgeBatch edges(mesh.faces.rows(), 1);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const Eigen::Vector3d a = mesh.points.row(mesh.faces(f, 0));
    Eigen::Matrix<double, 3, 2> wanted;
    wanted.col(0) = map * (mesh.points.row(mesh.faces(f, 1)).transpose() - a);
    wanted.col(1) = map * (mesh.points.row(mesh.faces(f, 2)).transpose() - a);
    edges.Set(f, 0, wanted);
  }
  return edges;
}

PointsX3 After(const Mesh& mesh, const Eigen::Matrix3d& map) {
  return mesh.points * map.transpose();
}

TEST(PoissonSystem, EdgesOfALinearMapGiveItExactly) {
  const Mesh ball = MakeIcosphere(3);
  const PoissonSystem system({ball.points}, ball.faces);
  EXPECT_TRUE(system.IsFree());
  EXPECT_EQ(system.part_count(), 1);
  const Eigen::Matrix3d map = Eigen::AngleAxisd(2, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                              Eigen::Vector3d(1, 2, 0.5).asDiagonal();
  const PointsX3 wanted = After(ball, map);
  const auto frames = system.Solve(Mapped(ball, map), {system.RowsAt(wanted)});
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_LT((frames[0] - wanted).cwiseAbs().maxCoeff(), 1e-11);
}

ConstraintRow PinOf(int vertex, const std::string& name) {
  ConstraintRow row;
  row.terms = {{vertex, 1.0}};
  row.name = name;
  return row;
}

TEST(PoissonSystem, ExactRowsHoldAndASpringGivesWay) {
  const Mesh ball = MakeIcosphere(2);
  ConstraintRow pulled = PinOf(1, "pulled");
  for (const double compliance : {0.0, 1.0}) {
    pulled.compliance = compliance;
    const PoissonSystem system({ball.points}, ball.faces, {PinOf(0, "held"), pulled});
    ASSERT_EQ(system.row_sources(), (std::vector<int>{0, 1}));
    RowTargets targets = system.RowsAt(ball.points);
    targets.row(1) *= 2;
    const PointsX3 solved = system.Solve(Mapped(ball, Eigen::Matrix3d::Identity()), {targets})[0];
    EXPECT_LT((solved.row(0) - ball.points.row(0)).norm(), 1e-11);
    const double gap = (solved.row(1) - targets.row(1)).norm();
    if (compliance == 0)
      EXPECT_LT(gap, 1e-11);
    else
      EXPECT_GT(gap, 1e-3);
  }
}

TEST(PoissonSystem, DependentRowsAreDroppedByNameAndUnknownVerticesThrow) {
  const Mesh ball = MakeIcosphere(1);
  ConstraintRow once, again;
  once.terms = {{3, 1.0}};
  once.name = "once";
  again.terms = {{3, 2.0}};
  again.name = "again";
  const PoissonSystem system({ball.points}, ball.faces, {once, again});
  ASSERT_EQ(system.dropped_rows().size(), 1u);
  EXPECT_EQ(system.dropped_rows()[0], "again");
  once.terms = {{ball.vertex_count(), 1.0}};
  EXPECT_THROW(PoissonSystem({ball.points}, ball.faces, {once}), InputError);
}

TEST(PoissonSystem, ConstantsStayWhenFacesAreSmoothedOverVertices) {
  const Mesh ball = MakeIcosphere(2);
  const PoissonSystem system({ball.points}, ball.faces);
  const Eigen::MatrixXd smooth =
      system.SmoothOverVertices(Eigen::MatrixXd::Constant(ball.faces.rows(), 1, 3.5));
  EXPECT_LT((smooth.array() - 3.5).abs().maxCoeff(), 1e-10);
}

TEST(PoissonSystem, APinnedBodyIsBentToTheFloorAndNotAbove) {
  const Mesh ball = MakeIcosphere(2);
  Eigen::Index top = 0;
  ball.points.col(2).maxCoeff(&top);
  const PoissonSystem system({ball.points}, ball.faces, {PinOf(static_cast<int>(top), "top")});
  PointsX3 points = ball.points;
  Floor floor;
  floor.height = -0.8;
  EXPECT_FALSE(system.LiftToFloor(points, floor).empty());
  EXPECT_NEAR(points.col(2).minCoeff(), -0.8, 1e-9);
  EXPECT_LT((points.row(top) - ball.points.row(top)).norm(), 1e-9);
  floor.height = -2;
  PointsX3 above = ball.points;
  EXPECT_TRUE(system.LiftToFloor(above, floor).empty());
  EXPECT_EQ(above, ball.points);
}

}  // namespace keypose::poisson_test
