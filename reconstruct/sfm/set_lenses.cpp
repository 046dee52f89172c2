#include "reconstruct/sfm/set_lenses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "core/numbers/statistics.h"

namespace keypose::reconstruct {
namespace {

constexpr double kOneLens = 0.1;    // relative difference of focal lengths
constexpr std::size_t kFewest = 3;  // photographs of a lens
constexpr double kGuess = 1.2;      // focal length over the longer side

/// Photographs of one size and about one focal length.
struct Group {
  std::vector<int> images;
  std::vector<double> focals;  // known ones, ascending
};

/// The photographs of one size in groups of like focal length, the shortest first.
std::vector<Group> ByFocal(const ImageSet& set, const std::vector<int>& images) {
  std::vector<std::pair<double, int>> known;
  std::vector<int> unknown;
  for (const int i : images) {
    const double focal = set.images[static_cast<std::size_t>(i)].focal_px;
    if (focal > 0)
      known.emplace_back(focal, i);
    else
      unknown.push_back(i);
  }
  std::sort(known.begin(), known.end());
  std::vector<Group> groups;
  for (const auto& [focal, image] : known) {
    if (groups.empty() || focal > (1 + kOneLens) * groups.back().focals.front())
      groups.emplace_back();
    groups.back().focals.push_back(focal);
    groups.back().images.push_back(image);
  }
  for (std::size_t g = 0; groups.size() > 1 && g < groups.size();) {
    if (groups[g].images.size() >= kFewest) {
      ++g;
      continue;
    }
    Group& into = groups[g == 0 ? 1 : g - 1];
    into.images.insert(into.images.end(), groups[g].images.begin(), groups[g].images.end());
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(g));
  }
  if (groups.empty()) groups.emplace_back();
  Group& most = *std::max_element(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
    return a.images.size() < b.images.size();
  });
  most.images.insert(most.images.end(), unknown.begin(), unknown.end());
  return groups;
}

/// As written, and as photographed: what had several sizes is of several cameras, though it may be
/// written in one.
std::array<int, 4> SizesOf(const CapturedImage& image) {
  const bool as_it_was = image.photograph_width <= 0 || image.photograph_height <= 0;
  const auto [shorter, longer] =
      as_it_was ? std::minmax({image.width, image.height})
                : std::minmax({image.photograph_width, image.photograph_height});
  return {image.width, image.height, longer, shorter};
}

}  // namespace

SetLenses LensesOf(const ImageSet& set) {
  std::map<std::array<int, 4>, std::vector<int>> by_size;
  for (int i = 0; i < static_cast<int>(set.images.size()); ++i) {
    const CapturedImage& image = set.images[static_cast<std::size_t>(i)];
    by_size[SizesOf(image)].push_back(i);
  }
  std::vector<Group> groups;
  std::vector<double> relative;  // focal lengths over the longer side
  for (const auto& [size, images] : by_size)
    for (Group& group : ByFocal(set, images)) {
      for (const double focal : group.focals)
        relative.push_back(focal / std::max(size[0], size[1]));
      groups.push_back(std::move(group));
    }
  for (Group& group : groups) std::sort(group.images.begin(), group.images.end());
  std::sort(groups.begin(), groups.end(),
            [](const Group& a, const Group& b) { return a.images.front() < b.images.front(); });
  SetLenses lenses;
  lenses.focal_known = !relative.empty();
  lenses.of_image.resize(set.images.size());
  for (const Group& group : groups) {
    const CapturedImage& image = set.images[static_cast<std::size_t>(group.images.front())];
    Camera camera;
    camera.width = image.width;
    camera.height = image.height;
    const double side = std::max(camera.width, camera.height);
    if (!group.focals.empty())
      camera.fx = UpperMedian(group.focals);
    else
      camera.fx = (relative.empty() ? kGuess : UpperMedian(relative)) * side;
    camera.fy = camera.fx;
    camera.cx = camera.width / 2.0;
    camera.cy = camera.height / 2.0;
    for (const int i : group.images)
      lenses.of_image[static_cast<std::size_t>(i)] = static_cast<int>(lenses.cameras.size());
    lenses.cameras.push_back(camera);
  }
  return lenses;
}

}  // namespace keypose::reconstruct
