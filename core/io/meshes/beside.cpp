#include "core/io/meshes/beside.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "core/values/file_names.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

/// The entry of a folder with this name, else one that differs in capitals alone: the first by its
/// bytes, so that it is always the same. Empty: none.
fs::path Entry(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  if (fs::exists(folder / name, ignored)) return folder / name;
  std::vector<fs::path> found;
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end;
       it.increment(ignored))
    if (LowerCase(it->path().filename().string()) == LowerCase(name)) found.push_back(it->path());
  if (found.empty()) return {};
  return *std::min_element(found.begin(), found.end());
}

/// @param path  parts between '/', which stay below the folder
fs::path FileBelow(fs::path folder, std::string_view path) {
  for (;;) {
    const std::size_t slash = path.find('/');
    folder = Entry(folder, std::string(path.substr(0, slash)));
    if (folder.empty() || slash == path.npos) break;
    path.remove_prefix(slash + 1);
  }
  std::error_code ignored;
  return fs::is_regular_file(folder, ignored) ? folder : fs::path();
}

}  // namespace

fs::path FileBeside(const fs::path& owner, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  while (name.starts_with("./")) name.erase(0, 2);
  const fs::path folder = owner.has_parent_path() ? owner.parent_path() : fs::path(".");
  for (const std::string& candidate : {name, name.substr(name.rfind('/') + 1)}) {
    if (!StaysBelow(candidate)) continue;
    const fs::path file = FileBelow(folder, candidate);
    if (!file.empty()) return file;
  }
  return {};
}

std::string WithoutPercents(std::string_view uri) {
  std::string name;
  for (std::size_t at = 0; at < uri.size(); ++at) {
    unsigned code = 0;
    const char *const begin = uri.data() + at + 1, *const stop = uri.data() + uri.size();
    const bool coded = uri[at] == '%' && stop - begin >= 2 &&
                       std::from_chars(begin, begin + 2, code, 16).ptr == begin + 2;
    name += coded ? static_cast<char>(code) : uri[at];
    if (coded) at += 2;
  }
  return name;
}

}  // namespace keypose
