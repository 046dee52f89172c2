#include "core/io/text/xml_depth.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::xml_depth_test {

std::string Nested(int levels) {
  std::string text;
  for (int i = 0; i < levels; ++i) text += "<a b='>'>";
  for (int i = 0; i < levels; ++i) text += "</a>";
  return text;
}

TEST(RequireShallowXml, RefusesMoreThanAHundredLevels) {
  EXPECT_NO_THROW(RequireShallowXml(Nested(100), "x"));
  EXPECT_THROW(RequireShallowXml(Nested(101), "x"), InputError);
  std::string wide = "<a>";
  for (int i = 0; i < 300; ++i) wide += "<b/><!-- <c> --><![CDATA[<d>]]>";
  EXPECT_NO_THROW(RequireShallowXml(wide + "</a>", "x"));
}

}  // namespace keypose::xml_depth_test
