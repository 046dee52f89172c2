#include "core/io/pictures/picture_codec.h"

#include <dlfcn.h>
#include <gmock/gmock.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/testing/folder.h"

namespace keypose::picture_codec_test {

bool Loaded() { return dlopen("libOpenImageIO.so.2.4", RTLD_LAZY | RTLD_NOLOAD) != nullptr; }

/// Threads that all want the first picture, in a process where nothing was loaded.
void ReadByThreads(const std::filesystem::path& file) {
  if (Loaded()) std::exit(1);
  std::atomic<int> right = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) threads.emplace_back([&] { right += ReadImage(file, 3).width == 5; });
  for (std::thread& thread : threads) thread.join();
  std::exit(right == 8 && Loaded() ? 0 : 2);
}

TEST(PictureCodec, IsLoadedWithTheFirstPictureByAnyThread) {
  const TestingFolder folder;
  const auto file = folder.path() / "five.png";
  WritePng(file, Image8(5, 2, 3));  // by libpng alone
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(ReadByThreads(file), ::testing::ExitedWithCode(0), "");
}

}  // namespace keypose::picture_codec_test
