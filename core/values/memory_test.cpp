#include "core/values/memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "core/values/errors.h"

namespace keypose::memory_test {

using ::testing::HasSubstr;

std::vector<View> Cameras(int count, int width, int height) {
  std::vector<View> views(count);
  for (View& view : views) view.camera.width = width, view.camera.height = height;
  return views;
}

std::string Fault(const std::function<void()>& run) {
  try {
    run();
  } catch (const DiskError& error) {
    return error.what();
  }
  return "";
}

TEST(Memory, IsThereForALittleAndNotForAPetabyte) {
  EXPECT_GT(FreeMemory(), 0);
  EXPECT_EQ(Fault([] { RequireMemory(1, "one byte"); }), "");
  EXPECT_THAT(Fault([] { RequireMemory(std::int64_t{1} << 50, "cloud.ply"); }),
              HasSubstr("cloud.ply needs 1125899.9 GB of memory"));
}

TEST(MemoryForViews, CountsThePixelsOfAllPicturesAtTheSizeThatIsWorkedOn) {
  const auto views = Cameras(1000, 40000, 30000);  // 1.2e12 pixels
  EXPECT_THAT(Fault([&] { RequireMemoryForViews("bake", views, 1, 5); }),
              HasSubstr("bake: the work on 1000 photographs (1200000 megapixels) needs 6000.0 GB"));
  EXPECT_THAT(Fault([&] { RequireMemoryForViews("dense", views, 0.5, 5); }),
              HasSubstr("needs 1500.0 GB"));
  EXPECT_EQ(Fault([] { RequireMemoryForViews("bake", Cameras(30, 1000, 800), 1, 5); }), "");
}

}  // namespace keypose::memory_test
