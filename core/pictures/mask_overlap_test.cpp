#include "core/pictures/mask_overlap.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace keypose::mask_overlap_test {

Image8 Row(const std::vector<std::uint8_t>& values) {
  Image8 mask(static_cast<int>(values.size()), 1, 1);
  mask.data = values;
  return mask;
}

TEST(MaskIoU, IsTheSharedPartOfBoth) {
  const Image8 a = Row({255, 255, 255, 0, 0}), b = Row({0, 255, 255, 255, 0});
  EXPECT_EQ(MaskIoU(a, b), 0.5);
  EXPECT_EQ(MaskIoU(a, a), 1);
  EXPECT_EQ(MaskIoU(a, Row({0, 0, 0, 255, 255})), 0);
}

TEST(MaskIoU, CountsValuesAbove127) { EXPECT_EQ(MaskIoU(Row({127, 128}), Row({255, 255})), 0.5); }

TEST(MaskIoU, OfEmptyMasksIsWhatIsAskedFor) {
  EXPECT_EQ(MaskIoU(Row({0, 0}), Row({0, 0})), 0);
  EXPECT_EQ(MaskIoU(Row({0, 0}), Row({0, 0}), 1), 1);
}

}  // namespace keypose::mask_overlap_test
