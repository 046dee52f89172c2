#include "export/vat/vat_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::exporting::vat_layout_test {

TEST(MakeVatLayout, EveryVertexOfEveryFrameHasAPlaceOfItsOwn) {
  for (const int vertices : {1, 8192, 8193, 20000}) {
    const VatLayout layout = MakeVatLayout(vertices, 7);
    EXPECT_LE(layout.columns, kMostVatColumns);
    EXPECT_EQ(layout.rows_per_frame, (vertices - 1) / 8192 + 1);
    EXPECT_LT(layout.columns * layout.rows_per_frame - vertices, layout.rows_per_frame)
        << "no wider than needed";
    EXPECT_LT((vertices - 1) / layout.columns, layout.rows_per_frame);
  }
}

TEST(MakeVatLayout, TooManyFramesThrowInputErrorThatSaysHowManyFit) {
  EXPECT_EQ(MakeVatLayout(20000, 5461).rows(), 16383);
  try {
    MakeVatLayout(20000, 5462);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("at most 5461 frames"));
  }
}

}  // namespace keypose::exporting::vat_layout_test
