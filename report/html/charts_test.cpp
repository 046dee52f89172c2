#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "report/html/html.h"

namespace keypose::report::charts_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Charts, AreWellFormedSvg) {
  const std::string line = LineChart({{"ARAP", "#00f", {0, 0.5, 1}, {0, 0.01, 0.02}, false},
                                      {"linear", "#f00", {0, 0.5, 1}, {0, -0.3, 0}, true}},
                                     {"area", "t", "", true});
  const std::string bars =
      HistogramChart({{"ARAP", "#00f", {0.2, 0.5, 0.3}}}, -1, 1, {"faces", "d", "", true});
  for (const std::string& svg : {line, bars}) {
    EXPECT_THAT(svg, HasSubstr("ARAP"));
    EXPECT_FALSE(std::regex_search(svg, std::regex("=[^\"][^\\s>]*/>")))
        << "an unquoted value swallows the slash that ends its element";
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    const auto count = [&](const char* what) {
      int n = 0;
      for (std::size_t at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1))
        ++n;
      return n;
    };
    EXPECT_EQ(count("<text"), count("</text>"));
  }
  EXPECT_EQ(LineChart({}, {}), "");
  EXPECT_THAT(LineChart({{"flat", "#000", {0, 1}, {0, 0}, false}}, {}), Not(HasSubstr("nan")));
}

}  // namespace keypose::report::charts_test
