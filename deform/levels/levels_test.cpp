#include "deform/levels/levels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/surfaces/shapes.h"

namespace keypose::levels_test {

TEST(Levels, MarksKeepTheirPlaceOnEveryLevel) {
  const Mesh tube = MakeCylinder(0.3, 2, 30, 50);
  LandmarkGoal goal;
  goal.source.vertices = tube.faces.row(333).transpose();
  goal.source.weights << 0.2, 0.5, 0.3;
  goal.target << 1, 2, 3;
  Levels levels(tube.points, tube.faces, {500, 100},
                Eigen::VectorXd::LinSpaced(tube.vertex_count(), 1, 2), 0.001, {goal});
  ASSERT_EQ(levels.count(), 3);
  for (int l = 0; l < 3; ++l) {
    const Mark& mark = levels[l].marks.at(0);
    EXPECT_LT((levels[l].rest.row(mark.vertex).transpose() + mark.arm -
               PositionOf(goal.source, tube.points))
                  .norm(),
              1e-12);
    EXPECT_LT(mark.arm.norm(), 0.5);
    EXPECT_EQ(mark.target, goal.target);
  }
  levels.ScaleRest(2);
  EXPECT_LT((levels[0].rest - 2 * tube.points).cwiseAbs().maxCoeff(), 1e-12);
  const Mark& grown = levels[2].marks[0];
  EXPECT_LT((levels[2].rest.row(grown.vertex).transpose() + grown.arm -
             2 * PositionOf(goal.source, tube.points))
                .norm(),
            1e-12);
}

TEST(Levels, DescendHandsARigidMotionDown) {
  const Mesh tube = MakeCylinder(0.3, 2, 30, 50);
  Levels levels(tube.points, tube.faces, {500, 100}, {}, 0.001, {});
  ASSERT_EQ(levels.count(), 3);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.9, Eigen::Vector3d(1, 1, -3).normalized()).toRotationMatrix();
  levels[2].moved = levels[2].rest * turn.transpose();
  levels[2].fit->SetMaps(std::vector<Eigen::Matrix3d>(levels[2].rest.rows(), turn));
  levels.Descend(2);
  levels.Descend(1);
  EXPECT_LT((levels[0].moved - tube.points * turn.transpose()).cwiseAbs().maxCoeff(), 1e-12);
  for (const Eigen::Matrix3d& map : levels[0].fit->maps()) EXPECT_LT((map - turn).norm(), 1e-9);
}

}  // namespace keypose::levels_test
