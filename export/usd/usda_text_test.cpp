#include "export/usd/usda_text.h"

#include <gtest/gtest.h>

#include "export/usd/usda.h"

namespace keypose::exporting::usda_text_test {

TEST(ShortNumber, IsTheShortestTextThatReadsBack) {
  EXPECT_EQ(ShortNumber(24), "24");
  EXPECT_EQ(ShortNumber(0.1), "0.1");
  EXPECT_EQ(ShortNumber(-2.999), "-2.999");
}

TEST(TupleArray, HasNumbersInSinglePrecision) {
  PointsX3 points(2, 3);
  points << 0.1, -1, 1e-7, 1.0 / 3, 2.5, 0;
  EXPECT_EQ(TupleArray(points), "[(0.1, -1, 1e-07), (0.33333334, 2.5, 0)]");
}

TEST(PrimName, IsAnIdentifierWhateverTheNameIs) {
  EXPECT_EQ(PrimName("character"), "character");
  EXPECT_EQ(PrimName("clay cat 2"), "clay_cat_2");
  EXPECT_EQ(PrimName("2nd"), "_2nd");
  EXPECT_EQ(PrimName("a\"\n{}</b>"), "a______b_");
  EXPECT_EQ(PrimName(""), "_");
}

}  // namespace keypose::exporting::usda_text_test
