#include "core/io/project/stiffness_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::stiffness_map_test {

TEST(ParseStiffness, TakesNumbersOnAnyLinesAndComments) {
  EXPECT_EQ(ParseStiffness("1 2.5 # soft\n\n0.125\n", 3, "s.txt"), Eigen::Vector3d(1, 2.5, 0.125));
}

TEST(ParseStiffness, NamesTheLineOfWhatIsNoStiffness) {
  for (const char* bad : {"1\n0\n1", "1\n-2\n1", "1\nsoft\n1", "1\n2x\n1", "1\nnan\n1"}) {
    try {
      ParseStiffness(bad, 3, "s.txt");
      ADD_FAILURE() << bad;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("s.txt:2: ")) << bad;
    }
  }
  EXPECT_THROW(ParseStiffness("1 1", 3, "s.txt"), InputError);
}

TEST(StiffnessFromColors, GreysAreAnEighthToEightTimes) {
  Mesh mesh;
  mesh.colors.resize(2, 3);
  mesh.colors << 0, 0, 0, 255, 255, 255;
  const Eigen::VectorXd stiffness = StiffnessFromColors(mesh, 2, "s.ply");
  EXPECT_NEAR(stiffness[0], 0.125, 1e-12);
  EXPECT_NEAR(stiffness[1], 8, 1e-12);
  EXPECT_THROW(StiffnessFromColors(mesh, 3, "s.ply"), InputError);
  EXPECT_THROW(StiffnessFromColors(Mesh(), 0, "s.ply"), InputError);
}

}  // namespace keypose::stiffness_map_test
