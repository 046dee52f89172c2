#include "armature/recording/still_joints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/recording/testing/walk.h"
#include "armature/testing/theropods.h"

namespace keypose::armature::still_joints_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(StillJoints, NamesTheOneThatStoppedAndNoOther) {
  const Armature theropod = MakeTheropod();
  const int knee = theropod.JointOf(theropod.Find("leftKneeBend"));
  auto frames = Frames(theropod, 9);
  for (int f = 6; f < 9; ++f) frames[f][knee] = frames[5][knee];
  EXPECT_THAT(StillJoints(theropod, frames), ElementsAre(knee));
  frames[7][knee] += 1e-9;
  EXPECT_THAT(StillJoints(theropod, frames), IsEmpty());
}

TEST(StillJoints, IsSilentWhenNothingMovesOrAllDoes) {
  const Armature theropod = MakeTheropod();
  for (int count = 0; count < 60; ++count)
    EXPECT_THAT(StillJoints(theropod, Frames(theropod, count)), IsEmpty());
  auto frames = Frames(theropod, 6);
  for (int f = 0; f < 4; ++f) frames.push_back(frames[5]);  // the puppet holds still
  EXPECT_THAT(StillJoints(theropod, frames), IsEmpty());
}

}  // namespace keypose::armature::still_joints_test
