#include "core/joined_images.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace keypose {

std::vector<std::vector<int>> JoinedImages(int images, const std::vector<ImageTie>& ties) {
  std::vector<int> parent(static_cast<std::size_t>(images));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  for (const ImageTie& tie : ties) {
    const int a = root(tie.first), b = root(tie.second);
    parent[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::vector<int>> members(parent.size());
  for (int i = 0; i < images; ++i) members[root(i)].push_back(i);
  std::erase_if(members, [](const std::vector<int>& group) { return group.empty(); });
  std::stable_sort(members.begin(), members.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return members;
}

bool FallsApart(int images, const std::vector<ImageTie>& ties, int strong_matches) {
  constexpr int kFewest = 20;
  constexpr std::size_t kRing = 8;
  if (images < kFewest) return false;
  const auto groups = JoinedImages(images, ties);
  if (groups.size() < 4 || groups[0].size() >= kRing ||
      3 * static_cast<int>(groups[0].size()) > images)
    return false;
  std::vector<char> strong(static_cast<std::size_t>(images), 0);
  for (const ImageTie& tie : ties)
    if (tie.matches >= strong_matches) strong[tie.first] = strong[tie.second] = 1;
  return 10 * std::count(strong.begin(), strong.end(), 1) >= 7 * images;
}

}  // namespace keypose
