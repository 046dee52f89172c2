#include "core/pictures/joined_images.h"

#include <algorithm>
#include <cstddef>

#include "core/values/size_of.h"
#include "core/values/union_find.h"

namespace keypose {

std::vector<std::vector<int>> JoinedImages(int images, const std::vector<ImageTie>& ties) {
  UnionFind joined(images);
  for (const ImageTie& tie : ties) joined.Join(tie.first, tie.second);
  std::vector<std::vector<int>> members(static_cast<std::size_t>(images));
  for (int i = 0; i < images; ++i) members[joined.Find(i)].push_back(i);
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
  if (groups.size() < 4 || groups[0].size() >= kRing || 3 * SizeOf(groups[0]) > images)
    return false;
  std::vector<char> strong(static_cast<std::size_t>(images), 0);
  for (const ImageTie& tie : ties)
    if (tie.matches >= strong_matches) strong[tie.first] = strong[tie.second] = 1;
  return 10 * std::count(strong.begin(), strong.end(), 1) >= 7 * images;
}

}  // namespace keypose
