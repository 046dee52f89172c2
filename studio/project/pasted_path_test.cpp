#include "studio/project/pasted_path.h"

#include <gtest/gtest.h>

namespace keypose::studio::pasted_path_test {

TEST(PastedPath, IsThePathThatIsMeant) {
  EXPECT_EQ(PastedPath("/home/me/clay fox"), "/home/me/clay fox");
  EXPECT_EQ(PastedPath("  '/home/me/clay fox'\n"), "/home/me/clay fox");
  EXPECT_EQ(PastedPath("\"~/fox\""), "~/fox");
  EXPECT_EQ(PastedPath("file:///home/me/clay%20fox"), "/home/me/clay fox");
  EXPECT_EQ(PastedPath("file://localhost/f%C3%BCchse"),
            "/f\xC3\xBC"
            "chse");
  EXPECT_EQ(PastedPath("/a/50%20 off"), "/a/50%20 off") << "a folder's own name";
  EXPECT_EQ(PastedPath("file:///a/100%"), "/a/100%");
  EXPECT_EQ(PastedPath("'"), "'");
  EXPECT_EQ(PastedPath(""), "");
}

}  // namespace keypose::studio::pasted_path_test
