#include "texture/packing/contact.h"

#include <gtest/gtest.h>

#include <vector>

#include "texture/packing/testing/outlines.h"

namespace keypose::texture::contact_test {

TEST(FindContacts, NearSquaresArePushedApartByHalfOfWhatIsMissingEach) {
  const std::vector<UvsX2> rims = {Rectangle(0.1, 0.4, 0.2, 0.2), Rectangle(0.31, 0.4, 0.2, 0.2)};
  const Contacts contacts = FindContacts(rims, 0.02, 0.05);
  EXPECT_NEAR(contacts.least_gap, 0.01, 1e-12);
  EXPECT_NEAR(contacts.push[0](1, 0), -0.005, 1e-12);
  EXPECT_NEAR(contacts.push[1](0, 0), 0.005, 1e-12);
  EXPECT_EQ(contacts.push[0](0, 0), 0);  // the far side has no contact
  EXPECT_NEAR(contacts.push[0](1, 1), 0, 1e-12);
}

TEST(FindContacts, DepthOfAnOverlapIsNegative) {
  const std::vector<UvsX2> rims = {Rectangle(0.1, 0.4, 0.2, 0.2), Rectangle(0.29, 0.45, 0.2, 0.1)};
  EXPECT_NEAR(FindContacts(rims, 0.02, 0.05).least_gap, -0.01, 1e-12);
}

TEST(FindContacts, BorderCountsForHalfOfTheGap) {
  const Contacts contacts = FindContacts({Rectangle(0.004, 0.4, 0.2, 0.2)}, 0.02, 0.05);
  EXPECT_NEAR(contacts.least_gap, 0.008, 1e-12);
  EXPECT_NEAR(contacts.push[0](0, 0), 0.006, 1e-12);
}

TEST(FindContacts, NarrowBayIsPushedOpenAndANeckIsNot) {
  UvsX2 bay(8, 2);  // a square with a slot of 0.004 from above
  bay << 0.3, 0.3, 0.5, 0.3, 0.5, 0.5, 0.402, 0.5, 0.402, 0.4, 0.398, 0.4, 0.398, 0.5, 0.3, 0.5;
  const Contacts contacts = FindContacts({bay}, 0.02, 0.05);
  EXPECT_GT(contacts.push[0](3, 0), 0);
  EXPECT_LT(contacts.push[0](6, 0), 0);
  UvsX2 neck = Rectangle(0.3, 0.3, 0.004, 0.2);
  EXPECT_TRUE(FindContacts({neck}, 0.02, 0.05).push[0].isZero(0));
}

TEST(AnyCross, BarsThatCrossWithAllCornersOutsideOfEachOther) {
  const std::vector<UvsX2> cross = {Rectangle(0.1, 0.45, 0.8, 0.1), Rectangle(0.45, 0.1, 0.1, 0.8)};
  EXPECT_TRUE(AnyCross(cross));
  EXPECT_FALSE(AnyCross({cross[0], Rectangle(0.45, 0.6, 0.1, 0.3)}));
}

}  // namespace keypose::texture::contact_test
