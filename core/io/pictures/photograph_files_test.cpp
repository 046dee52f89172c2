#include "core/io/pictures/photograph_files.h"

#include <gtest/gtest.h>

namespace keypose::photograph_files_test {

TEST(IsRawName, KnowsTheKindsOfTheBigMakersInAnyCase) {
  for (const char* name : {"a.CR2", "a.cr3", "a.NEF", "a.arw", "a.dng", "a.RAF", "a.orf", "a.rw2"})
    EXPECT_TRUE(IsRawName(name)) << name;
  for (const char* name : {"a.jpg", "a", ".dng", "a.dng.txt"})
    EXPECT_FALSE(IsRawName(name)) << name;
}

}  // namespace keypose::photograph_files_test
