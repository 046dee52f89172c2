#include "studio/project/changes.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::studio::changes_test {

TEST(JsonOfFile, NamesTheFileThatIsNone) {
  const TestingFolder own;
  EXPECT_EQ(JsonOfFile(own.Put("good.json", R"({"a": [1]})")).at("a").at(0), 1);
  try {
    JsonOfFile(own.Put("bad.json", "{"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("bad.json is not JSON"), std::string::npos);
  }
}

}  // namespace keypose::studio::changes_test
