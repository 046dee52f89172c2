#include "pipeline/disk/project_paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {

namespace fs = std::filesystem;

std::string WithHome(const std::string& path) {
  if (!path.starts_with("~")) return path;
  if (path.size() > 1 && path[1] != '/')
    throw UsageError(fmt::format(
        "{}: only your own home folder can be written as ~; write the whole path", path));
  const char* home = std::getenv("HOME");
  if (!home || !*home)
    throw UsageError(
        fmt::format("{}: HOME is not set, so ~ means nothing; write the whole path", path));
  return home + path.substr(1);
}

fs::path UserCacheFolder() {
  const auto folder_in = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value && value[0] == '/' ? value : "");
  };
  if (const fs::path cache = folder_in("XDG_CACHE_HOME"); !cache.empty()) return cache / "keypose";
  const fs::path home = folder_in("HOME");
  return home.empty() ? home : home / ".cache" / "keypose";
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
  // Sorted by path, the contents of a folder come right after it.
  std::vector<std::size_t> order(folders.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return folders[i].folder < folders[j].folder;
  });
  for (std::size_t k = 1; k < order.size(); ++k) {
    const PhotoFolder &b = folders[order[k - 1]], &a = folders[order[k]];
    if (!IsWithin(a.folder, b.folder)) continue;
    if (a.folder == b.folder) {
      return fmt::format(
          "the poses '{}' and '{}' have the same photographs, {}; each pose needs a folder of its "
          "own",
          b.pose, a.pose, a.folder.string());
    }
    return fmt::format(
        "the photographs of pose '{}', {}, lie inside the folder of pose '{}', {}; name the folder "
        "that has only the "
        "photographs of '{}'",
        a.pose, a.folder.string(), b.pose, b.folder.string(), b.pose);
  }
  return "";
}

}  // namespace keypose::pipeline
