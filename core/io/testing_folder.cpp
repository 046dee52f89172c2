#include "core/io/testing_folder.h"

#include <unistd.h>

#include <fstream>

namespace keypose {

TestingFolder::TestingFolder()
    : folder_(fs::temp_directory_path() / ("keypose_io_" + std::to_string(::getpid()))) {
  fs::create_directories(folder_);
}

TestingFolder::~TestingFolder() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

fs::path TestingFolder::Put(const std::string& name, const std::string& text) const {
  std::ofstream(folder_ / name, std::ios::binary) << text;
  return folder_ / name;
}

}  // namespace keypose
