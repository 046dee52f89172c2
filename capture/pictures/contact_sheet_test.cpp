#include "capture/pictures/contact_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/testing/test_images.h"

namespace keypose::capture::contact_sheet_test {

TEST(ContactCell, ShowsTheObjectUntintedAndTheRestTinted) {
  const TestPhoto photo = MakeTestPhoto(0, 240, 160, TestWall::kDark);
  const Image8 cell = ContactCell(photo.image, photo.truth, "a.jpg", 240);
  ASSERT_EQ(cell.width, 240);
  const std::uint8_t *corner = cell.at(5, 5), *middle = cell.at(118, 84);
  EXPECT_GT(corner[0], corner[1] + 60);  // magenta
  for (int c = 0; c < 3; ++c) EXPECT_EQ(middle[c], photo.image.at(118, 84)[c]);
}

TEST(LeftOutCell, IsGreyAndCrossedOut) {
  const Image8 image = MakeTestPhoto(0, 240, 160, TestWall::kDark).image;
  const Image8 cell = LeftOutCell(image, "a.jpg: left out", 240);
  ASSERT_EQ(cell.width, 240);
  const std::uint8_t *aside = cell.at(118, 40), *cross = cell.at(120, 80);
  EXPECT_EQ(aside[0], aside[2]);
  EXPECT_GT(cross[0], cross[1] + 100);
}

}  // namespace keypose::capture::contact_sheet_test
