#include "core/io/text/shared_files.h"

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <system_error>

namespace keypose {

namespace fs = std::filesystem;

namespace {

fs::path PlaceOf(const std::string& name) {
  std::string variable = "KEYPOSE_" + name;
  for (char& c : variable)
    c = std::isalnum(static_cast<unsigned char>(c))
            ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
            : '_';
  if (const char* chosen = std::getenv(variable.c_str()); chosen && *chosen) return chosen;
  std::error_code fault;
  const fs::path program = fs::read_symlink("/proc/self/exe", fault);
  return (program.parent_path() / "../share/keypose" / name).lexically_normal();
}

}  // namespace

std::optional<fs::path> FindSharedFile(const std::string& name) {
  const fs::path place = PlaceOf(name);
  std::error_code fault;
  if (!fs::is_regular_file(place, fault)) return std::nullopt;
  return place;
}

std::string SharedFileVersion(const std::string& name) {
  std::string version;
  if (const auto file = FindSharedFile(name)) {
    std::ifstream side(file->string() + ".sha256");
    side >> version;
  }
  return version.empty() ? "not installed" : version.substr(0, 64);
}

}  // namespace keypose
