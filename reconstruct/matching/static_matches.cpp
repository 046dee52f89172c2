#include "reconstruct/matching/static_matches.h"

#include <algorithm>

namespace keypose::reconstruct {

int RejectStaticMatches(const Features& first, const Features& second, int longer_side_px,
                        std::vector<std::pair<std::uint32_t, std::uint32_t>>& matches) {
  constexpr int kFewest = 8;
  const double limit = std::max(1.0, 0.001 * longer_side_px);
  const auto moved = [&](const std::pair<std::uint32_t, std::uint32_t>& match) {
    return static_cast<double>(
        (first.positions.row(match.first) - second.positions.row(match.second)).norm());
  };
  const auto in_place = std::count_if(matches.begin(), matches.end(),
                                      [&](const auto& m) { return moved(m) < limit; });
  const auto hardly = std::count_if(matches.begin(), matches.end(),
                                    [&](const auto& m) { return moved(m) < 3 * limit; }) -
                      in_place;
  if (in_place < kFewest || in_place <= hardly) return 0;
  return static_cast<int>(std::erase_if(matches, [&](const auto& m) { return moved(m) < limit; }));
}

}  // namespace keypose::reconstruct
