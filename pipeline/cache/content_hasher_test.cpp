#include "pipeline/cache/content_hasher.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/testing/memory_disk.h"

namespace keypose::pipeline::content_hasher_test {

TEST(ContentHasher, FilesThatDidNotChangeAreReadOnce) {
  MemoryDisk disk;
  disk.Write("/p/photos/a.jpg", "one");
  disk.Write("/p/photos/b.jpg", "two");
  std::string hash;
  {
    ContentHasher hasher(disk, "/p/.keypose/hashes", "/p");
    hash = hasher.Of("/p/photos").hash;
    EXPECT_EQ(hasher.files_read(), 2);
    hasher.Save();
  }
  ContentHasher again(disk, "/p/.keypose/hashes", "/p");
  EXPECT_EQ(again.Of("/p/photos").hash, hash);
  EXPECT_EQ(again.files_read(), 0);
  disk.Write("/p/photos/b.jpg", "three");
  EXPECT_NE(again.Of("/p/photos").hash, hash);
  EXPECT_EQ(again.files_read(), 1);
}

TEST(ContentHasher, LitterOfFileManagersDoesNotCount) {
  EXPECT_FALSE(CountsAsContent(".DS_Store"));
  EXPECT_FALSE(CountsAsContent("below/Thumbs.db"));
  EXPECT_TRUE(CountsAsContent("below/a.jpg"));
  MemoryDisk disk;
  disk.Write("/p/photos/a.jpg", "one");
  ContentHasher hasher(disk, "/p/.keypose/hashes", "/p");
  const std::string hash = hasher.Of("/p/photos").hash;
  disk.Write("/p/photos/.DS_Store", "litter");
  EXPECT_EQ(hasher.Of("/p/photos").hash, hash);
}

TEST(ContentHasher, WhatIsNotThereAndCancellingThrow) {
  MemoryDisk disk;
  ContentHasher hasher(disk, "/p/.keypose/hashes", "/p");
  EXPECT_THROW(hasher.Of("/p/none"), InputError);
  disk.Write("/p/a.jpg", "one");
  hasher.SetCancel([] { return true; });
  EXPECT_THROW(hasher.Of("/p/a.jpg"), Cancelled);
}

}  // namespace keypose::pipeline::content_hasher_test
