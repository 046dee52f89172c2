// A folder of its own for each test that writes files.
#pragma once

#include <filesystem>
#include <string>

namespace keypose {

namespace fs = std::filesystem;

/// A fixture's folder, which is gone with it.
class TestingFolder {
 public:
  TestingFolder();
  ~TestingFolder();
  TestingFolder(const TestingFolder&) = delete;
  TestingFolder& operator=(const TestingFolder&) = delete;

 protected:
  /// Writes a file. @return  its path
  fs::path Put(const std::string& name, const std::string& text) const;

  fs::path folder_;
};

}  // namespace keypose
