#include "report/html/html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::report::html_test {

TEST(Html, EscapesEncodesAndWritesNumbersForPeople) {
  EXPECT_EQ(Escape("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
  EXPECT_EQ(Base64("Man"), "TWFu");
  EXPECT_EQ(Base64("Ma"), "TWE=");
  EXPECT_EQ(Base64("M"), "TQ==");
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Pretty(1234567), "1\u202f234\u202f567");
  EXPECT_EQ(Pretty(0.5), "0.5000");
  EXPECT_EQ(Pretty(-2.5), "\u22122.5");
  EXPECT_EQ(PrettySeconds(245), "4 min 05 s");
  EXPECT_EQ(PrettyBytes(1.35e9), "1.35 GB");
  EXPECT_EQ(Percent(0.1234), "12.3\u00a0%");
}

}  // namespace keypose::report::html_test
