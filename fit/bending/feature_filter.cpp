#include "fit/bending/feature_filter.h"

#include <algorithm>

#include "core/numbers/kd_tree.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct FeatureFilterTuning {
  KEYPOSE_TUNED(double, kStretch, 1.25);   // of a picture's distance over the surface's
  KEYPOSE_TUNED(double, kAgreement, 0.5);  // share of the neighbours that must be possible
  KEYPOSE_TUNED(double, kSlackPx, 3);
  // Largest difference of a match's displacement from the median around it: pixels, and share.
  KEYPOSE_TUNED(double, kUnevenPx, 4);
  KEYPOSE_TUNED(double, kUneven, 0.5);
};

constexpr int kNeighbours = 8;
constexpr int kFilterRounds = 2;

}  // namespace

std::vector<int> ConsistentMatches(const PointsX3& rest, const std::vector<FeatureMatch>& matches,
                                   const Pinhole& camera, double distance) {
  std::vector<int> kept;
  for (int i = 0; i < SizeOf(matches); ++i) kept.push_back(i);
  for (int round = 0; round < kFilterRounds && SizeOf(kept) > kNeighbours; ++round) {
    PointsX3 places(SizeOf(kept), 3);
    for (int k = 0; k < SizeOf(kept); ++k) places.row(k) = PositionOf(matches[kept[k]].point, rest);
    const KdTree tree(places);
    std::vector<int> next;
    for (int k = 0; k < SizeOf(kept); ++k) {
      int possible = 0, tried = 0;
      for (const KdTree::Neighbor& near :
           tree.Nearest(places.row(k).transpose(), kNeighbours + 1)) {
        if (near.index == k) continue;
        const double apart = (places.row(near.index) - places.row(k)).norm();
        const double apart_px = (matches[kept[near.index]].pixel - matches[kept[k]].pixel).norm();
        const double most = FeatureFilterTuning::kStretch * apart * camera.fx / distance +
                            FeatureFilterTuning::kSlackPx;
        possible += apart_px <= most;
        ++tried;
      }
      if (possible >= FeatureFilterTuning::kAgreement * tried) next.push_back(kept[k]);
    }
    kept = std::move(next);
  }
  return kept;
}

std::vector<int> SmoothMatches(const PointsX3& rest, const std::vector<FeatureMatch>& matches,
                               const std::vector<Eigen::Vector2d>& shown) {
  std::vector<int> kept;
  if (matches.empty()) return kept;
  PointsX3 places(SizeOf(matches), 3);
  for (int i = 0; i < SizeOf(matches); ++i) places.row(i) = PositionOf(matches[i].point, rest);
  const KdTree tree(places);
  for (int i = 0; i < SizeOf(matches); ++i) {
    std::vector<double> x, y;
    for (const KdTree::Neighbor& near : tree.Nearest(places.row(i).transpose(), kNeighbours + 1)) {
      if (near.index == i) continue;
      const Eigen::Vector2d move = matches[near.index].pixel - shown[near.index];
      x.push_back(move.x());
      y.push_back(move.y());
    }
    if (x.empty()) continue;
    const Eigen::Vector2d median(UpperMedian(x), UpperMedian(y));
    const double apart = (matches[i].pixel - shown[i] - median).norm();
    if (apart <=
        std::max(FeatureFilterTuning::kUnevenPx, FeatureFilterTuning::kUneven * median.norm()))
      kept.push_back(i);
  }
  return kept;
}

std::vector<FeatureMatch> NearbyMatches(const PointsX3& rest, const PointsX3& now,
                                        const std::vector<FeatureMatch>& matches,
                                        const Pinhole& camera, const Rigid3& camera_from_world) {
  std::vector<FeatureMatch> consistent, smooth;
  std::vector<Eigen::Vector2d> shown;
  for (const int i :
       ConsistentMatches(rest, matches, camera, camera_from_world.translation.norm())) {
    consistent.push_back(matches[i]);
    shown.push_back(camera.Project(camera_from_world * PositionOf(matches[i].point, now)));
  }
  for (const int i : SmoothMatches(rest, consistent, shown)) smooth.push_back(consistent[i]);
  return smooth;
}

}  // namespace keypose::fit
