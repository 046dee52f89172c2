#include "pipeline/project_paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "core/errors.h"
#include "pipeline/text.h"

namespace keypose::pipeline {

namespace fs = std::filesystem;

std::string WithHome(const std::string& path) {
  if (!path.starts_with("~")) return path;
  if (path.size() > 1 && path[1] != '/')
    throw UsageError(fmt::format("{}: only your own home folder can be written as ~; write the whole path", path));
  const char* home = std::getenv("HOME");
  if (!home || !*home) throw UsageError(fmt::format("{}: HOME is not set, so ~ means nothing; write the whole path", path));
  return home + path.substr(1);
}

fs::path OnDisk(const Disk& disk, const fs::path& root, const fs::path& path) {
  if (disk.Stat(root / path)) return path;
  fs::path found;
  for (const fs::path& part : path) {
    fs::path next = found / part;
    if (!disk.Stat(root / next)) {
      const std::string wanted = Composed(part.string());
      for (const std::string& name : disk.Children(root / found)) {
        if (Composed(name) == wanted) next = found / name;
      }
      if (!disk.Stat(root / next)) return path;
    }
    found = next;
  }
  return found;
}

std::string SharedPhotographs(const std::vector<PhotoFolder>& folders) {
  const auto inside = [](const fs::path& inner, const fs::path& outer) {
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
  };
  for (std::size_t i = 0; i < folders.size(); ++i) {
    for (std::size_t j = 0; j < folders.size(); ++j) {
      const PhotoFolder &a = folders[i], &b = folders[j];
      if (i == j || !inside(a.folder, b.folder)) continue;
      if (a.folder == b.folder) {
        return fmt::format("the poses '{}' and '{}' have the same photographs, {}; each pose needs a folder of its own",
                           folders[std::min(i, j)].pose, folders[std::max(i, j)].pose, a.folder.string());
      }
      return fmt::format(
          "the photographs of pose '{}', {}, lie inside the folder of pose '{}', {}; name the folder that has only the "
          "photographs of '{}'",
          a.pose, a.folder.string(), b.pose, b.folder.string(), b.pose);
    }
  }
  return "";
}

}  // namespace keypose::pipeline
