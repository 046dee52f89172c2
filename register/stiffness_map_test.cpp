#include <gtest/gtest.h>

#include "core/io/project/stiffness_map.h"
#include "core/values/errors.h"

namespace keypose::registration::stiffness_map_test {

TEST(ParseStiffness, ReadsNumbersAndNamesTheBadLine) {
  EXPECT_EQ(ParseStiffness("1 2\n# half\n0.5\n", 3, "map.txt")[2], 0.5);
  EXPECT_THROW(ParseStiffness("1 2", 3, "map.txt"), InputError);
  try {
    ParseStiffness("1\n2\n-3\n", 3, "map.txt");
    FAIL() << "negative stiffness accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind("map.txt:3:", 0), 0u);
  }
}

}  // namespace keypose::registration::stiffness_map_test
