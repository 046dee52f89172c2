// The layout of FBX files: written, read back, cut off and damaged.
#include "export/fbx/fbx_records.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/values/errors.h"

namespace keypose::exporting::fbx_records_test {

using ::testing::ElementsAre;

std::vector<FbxRecord> SomeRecords() {
  const std::vector<double> even(1000, 0.25);  // shorter when compressed
  const std::vector<double> few{1, -2.5, 1e300};
  return {{"Scalars", {true, 7, std::int64_t{1} << 40, -0.5, "text"}},
          {"Empty"},
          {"Outer",
           {FbxName("clay", "Material")},
           {{"Arrays", {even, few, std::vector<std::int32_t>{}, std::vector<float>{0.5f, 3}}},
            {"Deep", {}, {{"Times", {std::vector<std::int64_t>{0, std::int64_t{1} << 50}}}}},
            {"Bytes", {FbxValue::Binary(std::string("\0\xff\n", 3))}}}}};
}

TEST(WriteFbx, WhatIsWrittenIsReadBack) {
  const std::vector<FbxRecord> records = ReadFbx(WriteFbx(SomeRecords()));
  ASSERT_EQ(records.size(), 3u);
  const FbxRecord& outer = records[2];
  EXPECT_EQ(records[0].values[0].type(), 'C');
  EXPECT_EQ(records[0].values[1].AsInteger(), 7);
  EXPECT_EQ(records[0].values[2].AsInteger(), std::int64_t{1} << 40);
  EXPECT_EQ(records[0].values[4].AsText(), "text");
  EXPECT_EQ(outer.values[0].AsText(), std::string("clay\0\1Material", 14));
  const std::vector<FbxValue>& arrays = outer.Inner("Arrays").values;
  EXPECT_EQ(arrays[0].AsDoubles(), std::vector<double>(1000, 0.25));
  EXPECT_LT(arrays[0].stored().size(), 100u) << "compressed";
  EXPECT_THAT(arrays[1].AsDoubles(), ElementsAre(1, -2.5, 1e300));
  EXPECT_TRUE(arrays[2].AsIntegers().empty());
  EXPECT_THAT(arrays[3].AsFloats(), ElementsAre(0.5f, 3.0f));
  EXPECT_EQ(outer.Inner("Deep").Inner("Times").values[0].AsTimes()[1], std::int64_t{1} << 50);
  EXPECT_EQ(outer.Inner("Bytes").values[0].AsText(), std::string("\0\xff\n", 3));
}

// Autodesk's own files: the version stands four bytes after a multiple of 16, behind the code and 5
// to 20 zeros, and the file ends 140 bytes later.
TEST(WriteFbx, FooterIsWhereAutodeskPutsItForEveryLength) {
  for (int length = 0; length < 16; ++length) {
    const std::string bytes = WriteFbx({{"Text", {std::string(length, 'x')}}});
    ASSERT_EQ(bytes.size() % 16, 0u) << length;
    const std::size_t at = bytes.size() - 140;
    std::int32_t version = 0;
    std::memcpy(&version, bytes.data() + at, 4);
    EXPECT_EQ(version, 7400) << length;
    const std::size_t code = bytes.rfind("\xfa\xbc\xab\x09", at);
    ASSERT_NE(code, std::string::npos) << length;
    EXPECT_GE(at - code - 16, 5u) << length;
    EXPECT_LE(at - code - 16, 20u) << length;
    EXPECT_EQ(bytes.substr(code + 16, at - code - 16), std::string(at - code - 16, '\0'));
  }
}

TEST(WriteFbx, MoreBytesThanTheFormatCountsThrowInputError) {
  const std::string bytes = WriteFbx(SomeRecords());
  EXPECT_NO_THROW(WriteFbx(SomeRecords(), bytes.size() + 100));
  try {
    WriteFbx(SomeRecords(), bytes.size() - 100);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("use fewer in-betweens"));
  }
}

TEST(ReadFbx, FileThatIsCutOffThrowsInputError) {
  const std::string bytes = WriteFbx(SomeRecords());
  const std::size_t records_end = bytes.size() - 140 - 20 - 16 - 13;
  for (std::size_t length = 0; length < records_end; ++length)
    ASSERT_THROW(ReadFbx(bytes.substr(0, length)), InputError) << length;
}

TEST(ReadFbx, NewerVersionThrowsInputError) {
  std::string bytes = WriteFbx(SomeRecords());
  const std::int32_t newer = 7500;
  std::memcpy(bytes.data() + 23, &newer, 4);
  EXPECT_THROW(ReadFbx(bytes), InputError);
}

TEST(ReadFbx, RecordOfAnotherLengthThrowsInputError) {
  std::string bytes = WriteFbx(SomeRecords());
  ++bytes[27];  // the end of the first record
  EXPECT_THROW(ReadFbx(bytes), InputError);
}

TEST(ReadFbx, ValueOfUnknownTypeThrowsInputError) {
  std::string bytes = WriteFbx({{"A", {true}}});
  bytes[bytes.find("AC") + 1] = '?';
  EXPECT_THROW(ReadFbx(bytes), InputError);
}

TEST(FbxValue, DamagedArrayThrowsInputError) {
  const std::string whole = FbxValue(std::vector<double>(1000, 0.25)).stored();
  std::string flipped = whole, longer = whole, plain = whole;
  flipped[20] = static_cast<char>(~flipped[20]);
  longer[4] = '\x7f';
  plain[5] = 0;
  EXPECT_THROW(FbxValue::Stored(flipped).AsDoubles(), InputError);
  EXPECT_THROW(FbxValue::Stored(longer).AsDoubles(), InputError);
  EXPECT_THROW(FbxValue::Stored(plain).AsDoubles(), InputError);
}

TEST(FbxValue, ValueOfAnotherTypeThrowsInputError) {
  EXPECT_THROW(FbxValue("1").AsInteger(), InputError);
  EXPECT_THROW(FbxValue(1).AsText(), InputError);
  EXPECT_THROW(FbxValue(1.0).AsDoubles(), InputError);
}

TEST(FbxRecord, MissingInnerRecordThrowsInputError) {
  EXPECT_THROW(SomeRecords()[2].Inner("Color"), InputError);
}

}  // namespace keypose::exporting::fbx_records_test
