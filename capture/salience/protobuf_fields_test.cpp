#include "capture/salience/protobuf_fields.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "capture/salience/testing/written_fields.h"

namespace keypose::capture::protobuf_fields_test {

TEST(WireFields, GiveBackWhatWasPut) {
  std::string message = Integer(1, 300) + Bytes(2, "text") + Integer(3, ~std::uint64_t{0});
  message += std::string("\x25\x01\x02\x03\x04", 5);  // field 4: four bytes
  const std::vector<WireField> fields = WireFields(message);
  ASSERT_EQ(fields.size(), 4U);
  EXPECT_EQ(fields[0].value, 300U);
  EXPECT_EQ(fields[1].bytes, "text");
  EXPECT_EQ(fields[2].value, ~std::uint64_t{0});
  EXPECT_EQ(fields[3].bytes, std::string_view("\x01\x02\x03\x04", 4));
  std::string again;
  for (const WireField& field : fields) PutField(again, field);
  EXPECT_EQ(again, message);
}

}  // namespace keypose::capture::protobuf_fields_test
