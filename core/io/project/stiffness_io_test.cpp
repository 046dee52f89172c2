#include "core/io/project/stiffness_io.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::stiffness_io_test {

/// Softer the higher it lies.
Eigen::VectorXd Graded(const Mesh& mesh) { return (1.5 + mesh.points.col(2).array()).matrix(); }

TEST(Stiffness, ComesBackOnItsOwnMeshAsItWasPainted) {
  const Mesh ball = MakeIcosphere(3);
  CarryLog log;
  const Eigen::VectorXd painted = Graded(ball);
  const Eigen::VectorXd read =
      StiffnessOn(ball, BoundStiffnessText(ball, painted), {}, "s.json", &log);
  ASSERT_EQ(read.size(), painted.size());
  EXPECT_LT((read - painted).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_TRUE(log.warnings.empty());
}

TEST(Stiffness, PlainNumbersAreTakenWithAWarning) {
  const TestingFolder folder;
  const Mesh box = MakeBox(1, 2, 3);
  CarryLog log;
  EXPECT_EQ(ReadStiffness(folder.Put("s.txt", "1 1 1 1 2 2 2 2\n"), box, &log)[4], 2);
  EXPECT_EQ(log.warnings.size(), 1u);
  EXPECT_THROW(ReadStiffness(folder.Put("s.txt", "1 1\n"), box, &log), InputError);
}

}  // namespace keypose::stiffness_io_test
