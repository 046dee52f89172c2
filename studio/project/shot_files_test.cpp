#include "studio/project/shot_files.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/values/errors.h"

namespace keypose::studio::shot_files_test {

TEST(WholeField, TakesWholeNumbersFromZeroOnly) {
  const auto of = [](const char* text) { return WholeField(nlohmann::json::parse(text), "frame"); };
  EXPECT_EQ(of(R"({"frame": 12})"), 12);
  EXPECT_EQ(of(R"({"frame": 0})"), 0);
  for (const char* text : {"{}", R"({"frame": -1})", R"({"frame": 1.5})", R"({"frame": "1"})",
                           R"({"frame": 5000000000})"})
    EXPECT_THROW(of(text), UsageError) << text;
}

}  // namespace keypose::studio::shot_files_test
