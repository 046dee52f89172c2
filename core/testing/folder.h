// A folder of its own for each test that writes files. In the header alone, so that tests of every
// room have it without a library to link.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

namespace keypose {

namespace fs = std::filesystem;

/// A folder that no other test has, nor another run of the same one: empty at first, and gone with
/// the object. A base of fixtures, or a variable of a test.
class TestingFolder {
 public:
  TestingFolder() : folder_(NewFolder()) {}
  ~TestingFolder() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  TestingFolder(const TestingFolder&) = delete;
  TestingFolder& operator=(const TestingFolder&) = delete;

  const fs::path& path() const { return folder_; }

  /// Writes a file. @return  its path
  fs::path Put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

 protected:
  const fs::path folder_;  ///< without links, as programs say it

 private:
  static fs::path NewFolder() {
    const fs::path all = fs::canonical(fs::temp_directory_path());
    std::string name = (all / "keypose_test_XXXXXX").string();
    if (!::mkdtemp(name.data()))
      throw std::runtime_error("no folder for the test in " + all.string());
    return name;
  }
};

}  // namespace keypose
