#include "fit/bending/feature_filter.h"

#include <algorithm>

#include "core/kd_tree.h"
#include "core/size_of.h"
#include "core/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct FeatureFilterTuning {
  KEYPOSE_TUNED(double, kStretch, 1.25);    // of a picture's distance over the surface's
  KEYPOSE_TUNED(double, kAgreement, 0.5);   // share of the neighbours that must be possible
  KEYPOSE_TUNED(double, kSlackPx, 3);
};

constexpr int kNeighbours = 8;
constexpr int kRounds = 2;

}  // namespace

std::vector<int> ConsistentMatches(const PointsX3& rest, const std::vector<FeatureMatch>& matches,
                                   const Pinhole& camera, double distance) {
  std::vector<int> kept;
  for (int i = 0; i < SizeOf(matches); ++i) kept.push_back(i);
  for (int round = 0; round < kRounds && SizeOf(kept) > kNeighbours; ++round) {
    PointsX3 places(SizeOf(kept), 3);
    for (int k = 0; k < SizeOf(kept); ++k) places.row(k) = PositionOf(matches[kept[k]].point, rest);
    const KdTree tree(places);
    std::vector<int> next;
    for (int k = 0; k < SizeOf(kept); ++k) {
      int possible = 0, tried = 0;
      for (const KdTree::Neighbor& near : tree.Nearest(places.row(k).transpose(), kNeighbours + 1)) {
        if (near.index == k) continue;
        const double apart = (places.row(near.index) - places.row(k)).norm();
        const double apart_px =
            (matches[kept[near.index]].pixel - matches[kept[k]].pixel).norm();
        const double most =
            FeatureFilterTuning::kStretch * apart * camera.fx / distance + FeatureFilterTuning::kSlackPx;
        possible += apart_px <= most;
        ++tried;
      }
      if (possible >= FeatureFilterTuning::kAgreement * tried) next.push_back(kept[k]);
    }
    kept = std::move(next);
  }
  return kept;
}

}  // namespace keypose::fit
