#include "pipeline/disk/zip_writer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::pipeline::zip_writer_test {

TEST(ZipWriter, HasItsNameOnlyWhenItIsComplete) {
  const TestingFolder own;
  const fs::path from = own.Put("a.txt", std::string(5000, 'a')), zip = own.path() / "p.zip";
  ZipWriter(zip).Add(from, "below/a.txt");
  EXPECT_FALSE(fs::exists(zip));

  ZipWriter writer(zip);
  writer.Add(from, "below/a.txt");
  const std::uint64_t size = writer.Finish();
  EXPECT_EQ(size, fs::file_size(zip));
  const std::string bytes = ReadFile(zip);
  EXPECT_EQ(bytes.substr(0, 4), "PK\x03\x04");
  EXPECT_NE(bytes.find("below/a.txt"), std::string::npos);
  EXPECT_LT(bytes.size(), 1000u);  // 5000 equal letters
}

TEST(ZipWriter, NothingIsReplacedAndAMissingFileIsNamed) {
  const TestingFolder own;
  own.Put("p.zip", "mine");
  EXPECT_THROW(ZipWriter(own.path() / "p.zip"), DiskError);
  EXPECT_EQ(ReadFile(own.path() / "p.zip"), "mine");
  ZipWriter writer(own.path() / "q.zip");
  try {
    writer.Add(own.path() / "none.txt", "none.txt");
    FAIL();
  } catch (const DiskError& error) {
    EXPECT_NE(std::string(error.what()).find("none.txt"), std::string::npos);
  }
}

}  // namespace keypose::pipeline::zip_writer_test
