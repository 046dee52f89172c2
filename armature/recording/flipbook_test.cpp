#include "armature/recording/flipbook.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/recording/testing/walk.h"
#include "armature/testing/theropods.h"

namespace keypose::armature::flipbook_test {

using ::testing::HasSubstr;

TEST(Flipbook, ShowsEachFrameInItsTime) {
  const Armature theropod = MakeTheropod();
  const std::string svg = FlipbookSvg(theropod, Walk(theropod, 4, 2));
  EXPECT_THAT(svg, HasSubstr("keyTimes=\"0;0.250000;0.500000\" dur=\"0.333333s\""));
  EXPECT_THAT(FlipbookSvg(theropod, Walk(theropod, 0, 1)), HasSubstr("</svg>"));
  EXPECT_THAT(FlipbookJson(theropod, Walk(theropod, 1, 1)), HasSubstr("\"sticks\":[["));
}

}  // namespace keypose::armature::flipbook_test
