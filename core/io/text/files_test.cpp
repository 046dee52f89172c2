#include "core/io/text/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/testing/damaged_file.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::files_test {

namespace fs = std::filesystem;

TEST_F(HostileFile, PipesDevicesAndFoldersAreNoFiles) {
  const fs::path fifo = folder_ / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", folder_ / "zero");
  fs::create_symlink(".", folder_ / "loop");
  for (const char* name : {"fifo", "zero", "loop"}) {
    const fs::path file = folder_ / name;
    Message<DiskError>(file, [&] { ReadFile(file); });
    Message<DiskError>(file, [&] { ReadMesh(file); });
    Message<DiskError>(file, [&] { ReadPointCloud(file); });
    Message<DiskError>(file, [&] { ReadImage(file); });
    Message<DiskError>(file, [&] { ReadImageInfo(file); });
  }
}

TEST(Utf8, KnowsWhatIsAndNamesWhatIsNot) {
  for (const char* good : {"", "clay", "T\xc3\xb6pferei", "\xe2\x82\xac", "\xf0\x9f\x90\xa2"})
    EXPECT_TRUE(IsValidUtf8(good)) << good;
  for (const char* bad :
       {"\xff", "\xc3", "a\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"})
    EXPECT_FALSE(IsValidUtf8(bad));
  EXPECT_EQ(WithoutOddBytes("T\xf6pferei \xe2\x82\xac"), "T?pferei \xe2\x82\xac");
  EXPECT_EQ(PrintableName("photos/T\xf6pf.jpg"), "T\\xf6pf.jpg");
}

class Files : public ::testing::Test, public TestingFolder {};

TEST_F(Files, FullDiskGivesDiskErrorAndNoFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(WriteFile("/dev/full", std::string(1 << 20, 'x')), DiskError);
}

TEST(NearestWord, FindsTheTypo) {
  EXPECT_EQ(NearestWord("facse", {"alpha", "faces", "offset"}), "faces");
}

}  // namespace keypose::files_test
