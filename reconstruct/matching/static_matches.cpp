#include "reconstruct/matching/static_matches.h"

#include <algorithm>

#include "core/values/tuned.h"

namespace keypose::reconstruct {

namespace {

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct StaticMatchTuning {
  KEYPOSE_TUNED(int, kFewest, 8);  // matches in place; with fewer none is rejected
  // of the longer side, and at least a pixel: matches that move less stay in place
  KEYPOSE_TUNED(double, kInPlace, 0.001);
  // of that limit: as many matches that move up to here are the object's own near the axis
  KEYPOSE_TUNED(double, kHardly, 3);
};

}  // namespace

int RejectStaticMatches(const Features& first, const Features& second, int longer_side_px,
                        std::vector<std::pair<std::uint32_t, std::uint32_t>>& matches) {
  const double limit = std::max(1.0, StaticMatchTuning::kInPlace * longer_side_px);
  const auto moved = [&](const std::pair<std::uint32_t, std::uint32_t>& match) {
    return static_cast<double>(
        (first.positions.row(match.first) - second.positions.row(match.second)).norm());
  };
  const auto in_place = std::count_if(matches.begin(), matches.end(),
                                      [&](const auto& m) { return moved(m) < limit; });
  const auto hardly =
      std::count_if(matches.begin(), matches.end(),
                    [&](const auto& m) { return moved(m) < StaticMatchTuning::kHardly * limit; }) -
      in_place;
  if (in_place < StaticMatchTuning::kFewest || in_place <= hardly) return 0;
  return static_cast<int>(std::erase_if(matches, [&](const auto& m) { return moved(m) < limit; }));
}

}  // namespace keypose::reconstruct
