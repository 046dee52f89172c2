#include "core/testing/paths.h"

#include <cstdlib>

namespace keypose {

const std::string& BinFolder() {
  static const std::string folder = KEYPOSE_BIN_DIR;
  return folder;
}

const std::string& SourceFolder() {
  static const std::string folder = KEYPOSE_SOURCE_DIR;
  return folder;
}

std::filesystem::path DataFolder() {
  const char* data = std::getenv("KEYPOSE_DATA");
  return data ? data : SourceFolder() + "/../shared/data";
}

}  // namespace keypose
