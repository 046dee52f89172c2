// Tests that write do so in a folder of their own, so that two runs on one machine do not meet.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>

#include "core/io/text/files.h"
#include "core/testing/paths.h"
#include "tests/include_rules.h"

namespace keypose::tests::test_folders_test {

/// Whether a test names the system's folder for temporary files itself.
bool NamesTemporaryFolder(const std::string& text) {
  static const std::regex pattern("temp_directory_path|TempDir\\(|mkdtemp|mkstemp|tmpnam");
  return std::regex_search(text, pattern);
}

TEST(TestFolders, AreAllTestingFolders) {
  const std::filesystem::path root = SourceFolder();
  // This file names them, and one makes the folders.
  const std::set<std::string> aside{"tests/test_folders_test.cpp", "core/testing/folder.h"};
  int takers = 0;
  for (const std::string& file : SourceFiles(root)) {
    static const std::regex test(".*_test\\.cpp|.*/testing/.*|tests/.*");
    if (!std::regex_match(file, test) || aside.contains(file)) continue;
    const std::string text = ReadFile(root / file);
    takers += text.find("TestingFolder") != std::string::npos;
    EXPECT_FALSE(NamesTemporaryFolder(text))
        << file << ": take a TestingFolder (core/testing/folder.h)";
  }
  EXPECT_GT(takers, 50);  // a search that finds no files would pass
}

TEST(TestFolders, OthersAreFound) {
  EXPECT_TRUE(NamesTemporaryFolder("fs::path(::testing::TempDir()) / \"keypose_fit_program\""));
  EXPECT_TRUE(NamesTemporaryFolder("fs::temp_directory_path() / name"));
  EXPECT_FALSE(
      NamesTemporaryFolder("class Files : public ::testing::Test, public TestingFolder {"));
}

}  // namespace keypose::tests::test_folders_test
