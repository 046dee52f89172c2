#include "core/values/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/values/errors.h"

namespace keypose {

namespace {

constexpr std::int64_t kUnknown = std::numeric_limits<std::int64_t>::max();

/// The number after `key` in a file with lines "key number"; kUnknown when there is none. With an
/// empty key, the first word of the file.
std::int64_t NumberIn(const std::string& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(key, 0) != 0) continue;
    std::istringstream words(line.substr(key.size()));
    std::int64_t number = 0;
    return words >> number ? number : kUnknown;
  }
  return kUnknown;
}

std::int64_t FreeOfSystem() {
  const std::int64_t kib = NumberIn("/proc/meminfo", "MemAvailable:");
  return kib == kUnknown ? kUnknown : 1024 * kib;
}

/// Free memory of this process's control group (version 2).
std::int64_t FreeOfGroup() {
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("0::", 0) != 0) continue;
    const std::string group = "/sys/fs/cgroup" + line.substr(3);
    const std::int64_t most = NumberIn(group + "/memory.max", ""),
                       now = NumberIn(group + "/memory.current", "");
    if (most != kUnknown && now != kUnknown) return std::max<std::int64_t>(0, most - now);
  }
  return kUnknown;
}

std::int64_t FreeOfProcess() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnknown;
  const std::int64_t pages = NumberIn("/proc/self/statm", "");
  if (pages == kUnknown) return kUnknown;
  return std::max<std::int64_t>(
      0, static_cast<std::int64_t>(limit.rlim_cur) - pages * sysconf(_SC_PAGESIZE));
}

std::string Gigabytes(std::int64_t bytes) {
  const std::int64_t tenths = (bytes + 50'000'000) / 100'000'000;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " GB";
}

}  // namespace

std::int64_t FreeMemory() { return std::min({FreeOfSystem(), FreeOfGroup(), FreeOfProcess()}); }

void RequireMemory(std::int64_t bytes, const std::string& what) {
  const std::int64_t free = FreeMemory();
  if (bytes > free)
    throw DiskError(what + " needs " + Gigabytes(bytes) + " of memory, and " + Gigabytes(free) +
                    " are free; close other programs, or make the pictures smaller");
}

void RequireMemoryForViews(const std::string& stage, const std::vector<View>& views, double scale,
                           double bytes_a_pixel) {
  double pixels = 0;
  for (const View& view : views)
    pixels += static_cast<double>(view.camera.width) * view.camera.height;
  RequireMemory(std::llround(pixels * scale * scale * bytes_a_pixel),
                stage + ": the work on " + std::to_string(views.size()) + " photographs (" +
                    std::to_string(std::llround(pixels / 1e6)) + " megapixels)");
}

}  // namespace keypose
