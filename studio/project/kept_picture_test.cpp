#include "studio/project/kept_picture.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "studio/project/not_found.h"

namespace keypose::studio::kept_picture_test {

TEST(KeptPicture, IsMadeOnceForEachContentAndName) {
  const TestingFolder own;
  const fs::path source = own.Put("a.jpg", "one"), kept = own.path() / "kept";
  int made = 0;
  const auto get = [&](const std::string& what) {
    return KeptPicture(kept, source, what, ".jpg", [&](const fs::path& path) {
      ++made;
      WriteFile(path, what);
    });
  };
  const fs::path small = get("small");
  EXPECT_EQ(get("small"), small);
  EXPECT_EQ(made, 1);
  EXPECT_EQ(ReadFile(small), "small");
  EXPECT_EQ(small.extension(), ".jpg");
  EXPECT_NE(get("large"), small);
  own.Put("a.jpg", "another");
  EXPECT_NE(get("small"), small);
  EXPECT_EQ(made, 3);
}

TEST(KeptPicture, OfAFileThatIsGoneIsNotFound) {
  const TestingFolder own;
  EXPECT_THROW(KeptPicture(own.path(), own.path() / "none.jpg", "small", ".jpg",
                           [](const fs::path&) { FAIL(); }),
               NotFound);
}

}  // namespace keypose::studio::kept_picture_test
