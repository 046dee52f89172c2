#include "studio/meshes/frame_order.h"

#include <algorithm>
#include <string>
#include <utility>

namespace keypose::studio {

namespace fs = std::filesystem;

void SortByNumber(std::vector<fs::path>* files) {
  std::sort(files->begin(), files->end(), [](const fs::path& a, const fs::path& b) {
    const std::string one = a.filename().string(), other = b.filename().string();
    return std::pair(one.size(), one) < std::pair(other.size(), other);
  });
}

}  // namespace keypose::studio
