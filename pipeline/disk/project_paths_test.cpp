#include "pipeline/disk/project_paths.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "core/values/errors.h"
#include "pipeline/testing/memory_disk.h"

namespace keypose::pipeline::project_paths_test {

TEST(WithHome, OnlyTheOwnHomeIsKnown) {
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0) {
    EXPECT_EQ(WithHome("~"), home);
    EXPECT_EQ(WithHome("~/photos"), std::string(home) + "/photos");
  }
  EXPECT_EQ(WithHome("photos/~"), "photos/~");
  EXPECT_THROW(WithHome("~lee/photos"), UsageError);
}

TEST(OnDisk, FindsUmlautsThatAreWrittenInTheOtherWay) {
  MemoryDisk disk;
  const std::string apart = "a\xcc\x88rger", composed = "\xc3\xa4rger";
  disk.Write("/p/" + apart + "/a.jpg", "");
  EXPECT_EQ(OnDisk(disk, "/p", composed + "/a.jpg"), apart + "/a.jpg");
  EXPECT_EQ(OnDisk(disk, "/p", apart + "/a.jpg"), apart + "/a.jpg");
  EXPECT_EQ(OnDisk(disk, "/p", "none/a.jpg"), "none/a.jpg");
}

TEST(SharedPhotographs, TwoPosesMayNotHaveOneFolderOrOneWithinTheOther) {
  EXPECT_EQ(SharedPhotographs({{"a", "/p/one"}, {"b", "/p/two"}, {"c", "/p/one-more"}}), "");
  EXPECT_NE(SharedPhotographs({{"a", "/p/one"}, {"b", "/p/one"}}), "");
  EXPECT_NE(SharedPhotographs({{"a", "/p/one/below"}, {"b", "/p/two"}, {"c", "/p/one"}}), "");
}

}  // namespace keypose::pipeline::project_paths_test
