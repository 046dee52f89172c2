#include "reconstruct/turntable/upside_down.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/numbers/statistics.h"
#include "core/pictures/image_turns.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

constexpr int kRows = 48;  ///< of an outline's profile

/// Tried on a ring of 16 columns with two photographs upside down (docs/results/cameras.md); no
/// record of single values. Sensitivity: docs/results/sensitivity.md.
struct UpsideDownTuning {
  /// least correlation of a pair's matched positions, in one of the orientations
  KEYPOSE_TUNED(double, kLeastLikeness, 0.5);
  KEYPOSE_TUNED(int, kFewestMatches, 10);  ///< of a pair that is asked
  /// a photograph is upside down if turned over its outline's distance is below this share of the
  /// distance as it is
  KEYPOSE_TUNED(double, kClearly, 0.6);
};

struct Tie {
  int first, second;
  double likeness;  ///< in [-1, 1]; below 0: one is upside down relative to the other
  double weight;
};

/// Correlation of matched positions about their means: 1 for the same picture, -1 for the same
/// picture upside down.
double Likeness(const PairPoints& pair) {
  Eigen::MatrixXd first = pair.xy.leftCols<2>(), second = pair.xy.rightCols<2>();
  first.rowwise() -= first.colwise().mean().eval();
  second.rowwise() -= second.colwise().mean().eval();
  return first.cwiseProduct(second).sum() / (first.norm() * second.norm() + 1e-12);
}

/// Groups of connected images, and each image's orientation relative to its group's root.
class Joined {
 public:
  explicit Joined(int images)
      : parent_(static_cast<std::size_t>(images)), flipped_(parent_.size(), 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int Root(int image, int& flipped) const {
    while (parent_[image] != image) {
      flipped ^= flipped_[image];
      image = parent_[image];
    }
    return image;
  }
  void Join(const Tie& tie) {
    int a = 0, b = 0;
    const int first = Root(tie.first, a), second = Root(tie.second, b);
    if (first == second) return;
    parent_[second] = first;
    flipped_[second] = a ^ b ^ (tie.likeness < 0 ? 1 : 0);
  }

 private:
  std::vector<int> parent_, flipped_;
};

/// Share of the picture's width that a mask covers, by rows.
Eigen::VectorXd Profile(const Image8& mask) {
  Eigen::VectorXd profile = Eigen::VectorXd::Zero(kRows);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      profile(static_cast<int>(static_cast<std::int64_t>(y) * kRows / mask.height)) +=
          *mask.at(x, y) > 127;
  return profile / mask.width;
}

}  // namespace

std::vector<int> UpsideDownByMatches(int images, const std::vector<PairPoints>& pairs) {
  std::vector<Tie> ties;
  for (const PairPoints& pair : pairs) {
    if (pair.xy.rows() < UpsideDownTuning::kFewestMatches) continue;
    const double likeness = Likeness(pair);
    if (std::abs(likeness) < UpsideDownTuning::kLeastLikeness) continue;
    ties.push_back({pair.first, pair.second, likeness,
                    std::abs(likeness) * std::sqrt(static_cast<double>(pair.xy.rows()))});
  }
  std::stable_sort(ties.begin(), ties.end(),
                   [](const Tie& a, const Tie& b) { return a.weight > b.weight; });
  Joined joined(images);
  for (const Tie& tie : ties) joined.Join(tie);
  // Groups: number of members, and how many differ in orientation from their root.
  std::vector<int> root(static_cast<std::size_t>(images)), side(root.size(), 0),
      size(root.size(), 0), over(root.size(), 0);
  for (int i = 0; i < images; ++i) {
    const auto k = static_cast<std::size_t>(i);
    root[k] = joined.Root(i, side[k]);
    ++size[root[k]];
    over[root[k]] += side[k];
  }
  const auto largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  std::vector<int> upside_down(root.size(), -1);
  if (size[largest] < 3) return upside_down;
  const bool root_is_over = 2 * over[largest] > size[largest];
  for (std::size_t k = 0; k < root.size(); ++k)
    if (root[k] == largest) upside_down[k] = side[k] ^ (root_is_over ? 1 : 0);
  return upside_down;
}

std::vector<int> UpsideDownByOutlines(std::vector<int> known, const std::vector<Image8>& masks) {
  std::vector<Eigen::VectorXd> profiles(masks.size());
  std::vector<std::size_t> upright;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    if (masks[i].empty()) continue;
    profiles[i] = Profile(known[i] == 1 ? TurnedOver(masks[i]) : masks[i]);
    upright.push_back(i);
  }
  if (upright.size() < 5) {
    std::replace(known.begin(), known.end(), -1, 0);
    return known;
  }
  Eigen::VectorXd usual(kRows);
  for (int r = 0; r < kRows; ++r) {
    std::vector<double> row;
    for (const std::size_t i : upright) row.push_back(profiles[i](r));
    usual(r) = UpperMedian(std::move(row));
  }
  for (std::size_t i = 0; i < masks.size(); ++i) {
    if (known[i] >= 0) continue;
    known[i] = 0;
    if (masks[i].empty()) continue;
    const double as_it_is = (profiles[i] - usual).norm(),
                 turned = (profiles[i].reverse() - usual).norm();
    known[i] = turned < UpsideDownTuning::kClearly * as_it_is;
  }
  return known;
}

}  // namespace keypose::reconstruct
