#include "core/values/late_library.h"

#include <gmock/gmock.h>

#include <string>

#include "core/values/errors.h"

namespace keypose::late_library_test {

using testing::HasSubstr;

LateLibrary missing("of_nobody", "test what is missing");

TEST(LateLibrary, OneThatIsMissingIsRefusedAtItsUseByItsPathAndPurpose) {
  LoadLateLibraries();
  for (const int again : {0, 1}) try {
      missing.Find("Nothing");
      FAIL() << again;
    } catch (const ToolError& error) {
      EXPECT_THAT(error.what(), HasSubstr("/lib/keypose/keypose_of_nobody.so, which is needed to "
                                          "test what is missing (/"));
      EXPECT_THAT(error.what(), HasSubstr("No such file"));
    }
}

}  // namespace keypose::late_library_test
