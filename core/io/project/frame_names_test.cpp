// Names as programs and cameras write them.
#include "core/io/project/frame_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/paths.h"

namespace keypose::frame_names_test {

using ::testing::HasSubstr;
using Names = std::vector<std::string>;
using Numbers = std::vector<long>;

TEST(NumberNames, TheNumberThatDiffersCounts) {
  const std::vector<std::pair<Names, Numbers>> cases{
      {{"shot_0001.v2", "shot_0002.v2", "shot_0004.v2"}, {1, 2, 4}},
      {{"shot2_v3_0009", "shot2_v3_0010"}, {9, 10}},
      {{"A001_0001_1920x1080", "A001_0002_1920x1080"}, {1, 2}},
      {{"DF_0007_X1", "DF_0008_X1"}, {7, 8}},
      {{"frame 9", "frame 10"}, {9, 10}},
      {{"0001-scene2-take4", "0002-scene2-take4"}, {1, 2}},
      {{"s_99999", "s_100000"}, {99999, 100000}},
      {{"f_-2", "f_-1", "f_0", "f_1"}, {-2, -1, 0, 1}},
      {{"shot-2", "shot-3"}, {2, 3}},
      {{"2024-05-03_0001", "2024-05-03_0002"}, {1, 2}},
      {{"20240503_000099", "20240503_000100"}, {99, 100}}};
  for (const auto& [names, numbers] : cases) {
    const FrameNumbering found = NumberNames(names);
    EXPECT_EQ(found.fault, "");
    EXPECT_TRUE(found.counted);
    EXPECT_EQ(found.numbers, numbers) << names[0];
  }
}

TEST(NumberNames, DatesAndTimesGiveTheOrder) {
  const std::vector<Names> in_order{
      {"2024-05-03 14.03.57", "2024-05-03 14.03.58", "2024-05-03 14.04.00", "2024-05-03 15.00.01"},
      {"IMG_20240503_140359", "IMG_20240503_140400", "IMG_20240504_090000"},
      {"PXL_20240503_140359123", "PXL_20240503_140359456", "PXL_20240503_140400001"},
      {"20240503140359", "20240503140400", "20240503150000"},
      {"Screenshot 2024-05-03 at 11.59.58 AM", "Screenshot 2024-05-03 at 12.00.01 PM",
       "Screenshot 2024-05-03 at 1.00.00 PM"},
      {"1714744000123", "1714744000456", "1714744001000"}};
  for (const Names& names : in_order) {
    const FrameNumbering found = NumberNames(names);
    EXPECT_EQ(found.fault, "");
    EXPECT_FALSE(found.counted) << names[0];
    Numbers expected;
    for (std::size_t i = 0; i < names.size(); ++i) expected.push_back(static_cast<long>(i));
    EXPECT_EQ(found.numbers, expected) << names[0];
  }
}

TEST(NumberNames, BesideOtherNumbersTheOneThatRunsEvenly) {
  EXPECT_EQ(
      NumberNames({"20240503_235959_0001", "20240504_000003_0002", "20240504_000004_0003"}).numbers,
      (Numbers{1, 2, 3}));
  EXPECT_EQ(NumberNames({"t12_0005", "t45_0006", "t46_0007", "t99_0008"}).numbers,
            (Numbers{5, 6, 7, 8}));
}

TEST(NumberNames, ACounterThatRanOverGoesOn) {
  EXPECT_EQ(NumberNames({"DSC_9998", "DSC_9999", "DSC_0001", "DSC_0002"}).numbers,
            (Numbers{9998, 9999, 10000, 10001}));
  EXPECT_EQ(NumberNames({"G9999", "G0000"}).numbers, (Numbers{9999, 10000}));
  EXPECT_EQ(NumberNames({"9998", "9999", "10000"}).numbers, (Numbers{9998, 9999, 10000}));
}

TEST(NumberNames, WhatCannotBeNumberedIsSaid) {
  EXPECT_THAT(NumberNames({"DF_0001_X1", "DF_0001_X2", "DF_0002_X1", "DF_0002_X2"}).fault,
              HasSubstr("of DF_0001_X1: 0001 and 1"));
  EXPECT_THAT(NumberNames({"a_01", "plate"}).fault, HasSubstr("plate has no frame number"));
  EXPECT_THAT(NumberNames({"a_01", "a_02", "a_02 (1)"}).fault,
              HasSubstr("a_02 (1) is not numbered as the others are"));
  EXPECT_THAT(NumberNames({"1234567890123456789012"}).fault, HasSubstr("has no frame number"));
  EXPECT_TRUE(NumberNames({}).numbers.empty());
}

TEST(NumberNames, ReportedNamesAreInTheirOrder) {
  const std::filesystem::path file = DataFolder() / "reports/26_film_names/order.json";
  if (!std::filesystem::is_regular_file(file)) GTEST_SKIP() << "the data folder is not here";
  const auto truth = nlohmann::json::parse(ReadFile(file));
  for (const auto& [kind, order] : truth.items()) {
    Names names;
    for (const auto& name : order)
      names.push_back(std::filesystem::path(name.get<std::string>()).stem().string());
    const FrameNumbering found = NumberNames(names);
    ASSERT_EQ(found.numbers.size(), names.size()) << kind << found.fault;
    EXPECT_TRUE(std::is_sorted(found.numbers.begin(), found.numbers.end())) << kind;
    if (kind != "gap") continue;
    EXPECT_EQ(found.numbers, (Numbers{0, 1, 2, 5, 6, 7}));
  }
}

}  // namespace keypose::frame_names_test
