#include "motion/body/body_template.h"

#include <gtest/gtest.h>

namespace keypose::motion::body_template_test {

TEST(BodyTemplate, HasSixteenSegmentsAndItsDofsAreAllUsedOnce) {
  std::array<int, kDofs> used{};
  for (int i = 0; i < 3; ++i) ++used[i];
  for (const JointModel& joint : Joints())
    for (int k = 0; k < (joint.ball ? 3 : static_cast<int>(joint.hinges.size())); ++k)
      ++used[joint.first_dof + k];
  for (int i = 0; i < kDofs; ++i) EXPECT_EQ(used[i], i >= 6 && i < 9 ? 2 : 1) << Dofs()[i].name;
  for (const DofModel& dof : Dofs()) EXPECT_FALSE(dof.name.empty());
  EXPECT_GE(kDofs, 35);
  EXPECT_LE(kDofs, 38);
}

}  // namespace keypose::motion::body_template_test
