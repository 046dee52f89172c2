#include "core/io/meshes/beside.h"

#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::beside_test {

namespace fs = std::filesystem;

class Beside : public ::testing::Test, public TestingFolder {
 protected:
  void Put(const std::string& name) {
    fs::create_directories((folder_ / name).parent_path());
    WriteFile(folder_ / name, "x");
  }
  fs::path Of(const std::string& name) { return FileBeside(folder_ / "in/fox.obj", name); }
};

TEST_F(Beside, NamesAsWindowsWritesThemAreFound) {
  Put("in/Maps/Fur 1.PNG");
  for (const char* name :
       {"Maps/Fur 1.PNG", "./Maps/Fur 1.PNG", "maps\\fur 1.png", ".\\MAPS\\Fur 1.png"})
    EXPECT_EQ(Of(name), folder_ / "in/Maps/Fur 1.PNG") << name;
}

TEST_F(Beside, OfAPathThatLeadsElsewhereTheFileBesideIsTaken) {
  Put("away/secret.png");
  for (const char* name : {"../away/secret.png", "/etc/secret.png", "C:\\Scans\\secret.png", ""}) {
    EXPECT_EQ(Of(name), "") << name;
  }
  Put("in/secret.png");
  for (const char* name : {"../away/secret.png", "/etc/secret.png", "C:\\Scans\\secret.png"})
    EXPECT_EQ(Of(name), folder_ / "in/secret.png") << name;
}

TEST_F(Beside, OfNamesThatDifferInCapitalsAloneTheExactOneIsTaken) {
  Put("in/a.png");
  Put("in/A.png");
  EXPECT_EQ(Of("a.png"), folder_ / "in/a.png");
  EXPECT_EQ(Of("A.png"), folder_ / "in/A.png");
}

TEST_F(Beside, PercentsOfAUriAreBytes) {
  EXPECT_EQ(WithoutPercents("a%20b%C3%A9.png"), "a b\xC3\xA9.png");
  EXPECT_EQ(WithoutPercents("100%"), "100%");
  EXPECT_EQ(WithoutPercents("%zz"), "%zz");
}

}  // namespace keypose::beside_test
