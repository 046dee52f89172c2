#include "fit/appearance/patch_search.h"

#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the photographs of a skull.
struct PatchSearchTuning {
  // A patch's pixels lie within this depth of its middle, in sides of the patch.
  KEYPOSE_TUNED(double, kDepth, 1.5);
  KEYPOSE_TUNED(double, kLeastPixels, 0.6);  // share of a patch that must be usable
  KEYPOSE_TUNED(double, kTurnStep, 0.28);    // between tried turns [rad]
  // A render this even shows nothing [grey levels].
  KEYPOSE_TUNED(double, kLeastContrast, 2);
};

constexpr double kOtherPlacePx = 3;  // from the best one
constexpr int kRefineReach = 2;      // px, around twice the coarse shift

struct PatchPixel {
  float dx, dy;  // from the vertex
  float value;
};

/// The usable pixels around a vertex in the render, with their mean taken off.
std::vector<PatchPixel> PatchAround(const SeenVertex& seen, const PatchPictures& pictures,
                                    int radius) {
  std::vector<PatchPixel> patch;
  const TexturedRender& render = pictures.render;
  const int cx = static_cast<int>(std::lround(seen.pixel.x())),
            cy = static_cast<int>(std::lround(seen.pixel.y()));
  const double near = PatchSearchTuning::kDepth * 2 * radius * seen.depth / pictures.focal;
  double sum = 0;
  for (int y = std::max(0, cy - radius); y <= std::min(render.grey.height - 1, cy + radius); ++y)
    for (int x = std::max(0, cx - radius); x <= std::min(render.grey.width - 1, cx + radius); ++x) {
      if (!(std::abs(*render.depth.at(x, y) - seen.depth) <= near)) continue;
      patch.push_back({static_cast<float>(x - seen.pixel.x()),
                       static_cast<float>(y - seen.pixel.y()), *render.grey.at(x, y)});
      sum += patch.back().value;
    }
  for (PatchPixel& pixel : patch)
    pixel.value -= static_cast<float>(sum / static_cast<double>(patch.size()));
  return patch;
}

bool Usable(const std::vector<PatchPixel>& patch, int radius) {
  const double side = 2 * radius + 1;
  if (SizeOf(patch) < PatchSearchTuning::kLeastPixels * side * side) return false;
  double square = 0;
  for (const PatchPixel& pixel : patch) square += pixel.value * pixel.value;
  const double least = PatchSearchTuning::kLeastContrast;
  return square > least * least * SizeOf(patch);
}

/// One patch over one photograph.
class Matcher {
 public:
  Matcher(const std::vector<PatchPixel>& patch, const Eigen::Vector2d& at,
          const PatchPictures& pictures)
      : patch_(patch), at_(at), pictures_(pictures), columns_(patch.size()), rows_(patch.size()) {}

  void Turn(double turn) {
    const double c = std::cos(turn), s = std::sin(turn);
    for (int i = 0; i < SizeOf(patch_); ++i) {
      const PatchPixel& p = patch_[i];
      columns_[i] = static_cast<int>(std::lround(at_.x() + c * p.dx - s * p.dy));
      rows_[i] = static_cast<int>(std::lround(at_.y() + s * p.dx + c * p.dy));
    }
  }

  /// -1 where the patch's middle or too much of it is outside of the mask.
  double At(int dx, int dy) const {
    if (!Inside(static_cast<int>(std::lround(at_.x())) + dx,
                static_cast<int>(std::lround(at_.y())) + dy))
      return -1;
    int count = 0;
    float sa = 0, saa = 0, sb = 0, sbb = 0, sab = 0;
    for (int i = 0; i < SizeOf(patch_); ++i) {
      const int x = columns_[i] + dx, y = rows_[i] + dy;
      if (!Inside(x, y)) continue;
      const float a = patch_[i].value, b = *pictures_.photo.at(x, y) - kGrey;
      sa += a;
      saa += a * a;
      sb += b;
      sbb += b * b;
      sab += a * b;
      ++count;
    }
    if (count < PatchSearchTuning::kLeastPixels * SizeOf(patch_)) return -1;
    const double n = count;
    const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
    if (!(va > 0) || !(vb > n)) return -1;  // an even photograph shows nothing
    return (sab - sa * sb / n) / std::sqrt(va * vb);
  }

 private:
  static constexpr float kGrey = 128;  // taken off, so that sums of squares stay exact enough

  bool Inside(int x, int y) const {
    return x >= 0 && y >= 0 && x < pictures_.photo.width && y < pictures_.photo.height &&
           InMask(*pictures_.mask.at(x, y));
  }

  const std::vector<PatchPixel>& patch_;
  Eigen::Vector2d at_;
  const PatchPictures& pictures_;
  std::vector<int> columns_, rows_;  // of the turned patch's pixels
};

/// For each shift within reach, the best correlation over all turns.
class ShiftTable {
 public:
  ShiftTable(Matcher& matcher, const PatchSearch& search)
      : reach_(static_cast<int>(search.reach_px)) {
    best_.assign(side() * side(), -1);
    turn_.assign(side() * side(), 0);
    const int turns = static_cast<int>(search.most_turn / PatchSearchTuning::kTurnStep);
    for (int t = -turns; t <= turns; ++t) {
      const double turn = t * PatchSearchTuning::kTurnStep;
      matcher.Turn(turn);
      for (int dy = -reach_; dy <= reach_; ++dy)
        for (int dx = -reach_; dx <= reach_; ++dx) {
          if (dx * dx + dy * dy > search.reach_px * search.reach_px) continue;
          const double value = matcher.At(dx, dy);
          const std::size_t i = Index(dx, dy);
          if (value > best_[i]) {
            best_[i] = value;
            turn_[i] = turn;
          }
        }
    }
  }

  FoundPatch Best(const PatchSearch& search) const {
    FoundPatch found;
    const std::size_t i = std::max_element(best_.begin(), best_.end()) - best_.begin();
    found.shift = {static_cast<double>(i % side()) - reach_,
                   static_cast<double>(i / side()) - reach_};
    found.turn = turn_[i];
    found.correlation = best_[i];
    if (found.correlation < search.least_correlation) return found;
    const double second = BestApart(found.shift);
    found.found = 1 - found.correlation <= search.best_ratio * (1 - second);
    return found;
  }

 private:
  std::size_t side() const { return 2 * static_cast<std::size_t>(reach_) + 1; }
  std::size_t Index(int dx, int dy) const {
    return static_cast<std::size_t>(dy + reach_) * side() + static_cast<std::size_t>(dx + reach_);
  }
  double BestApart(const Eigen::Vector2d& from) const {
    double best = -1;
    for (int dy = -reach_; dy <= reach_; ++dy)
      for (int dx = -reach_; dx <= reach_; ++dx)
        if ((Eigen::Vector2d(dx, dy) - from).norm() > kOtherPlacePx)
          best = std::max(best, best_[Index(dx, dy)]);
    return best;
  }

  int reach_;
  std::vector<double> best_, turn_;
};

}  // namespace

std::vector<FoundPatch> SearchPatches(const std::vector<SeenVertex>& seen,
                                      const PatchPictures& pictures, const PatchSearch& search) {
  std::vector<FoundPatch> found(seen.size());
  for (int i = 0; i < SizeOf(seen); ++i) {
    const std::vector<PatchPixel> patch = PatchAround(seen[i], pictures, search.radius);
    if (!Usable(patch, search.radius)) continue;
    Matcher matcher(patch, seen[i].pixel, pictures);
    found[i] = ShiftTable(matcher, search).Best(search);
  }
  return found;
}

std::vector<FoundPatch> RefinePatches(const std::vector<SeenVertex>& seen,
                                      const std::vector<FoundPatch>& coarse,
                                      const PatchPictures& pictures, const PatchSearch& search) {
  std::vector<FoundPatch> found(seen.size());
  for (int i = 0; i < SizeOf(seen); ++i) {
    if (!coarse[i].found) continue;
    const std::vector<PatchPixel> patch = PatchAround(seen[i], pictures, search.radius);
    if (!Usable(patch, search.radius)) continue;
    const Eigen::Vector2i middle = (2 * coarse[i].shift).array().round().cast<int>();
    Matcher matcher(patch, seen[i].pixel, pictures);
    FoundPatch& best = found[i];
    best.correlation = -1;
    for (const double turn : {-0.5, 0.0, 0.5}) {
      const double tried = coarse[i].turn + turn * PatchSearchTuning::kTurnStep;
      matcher.Turn(tried);
      for (int dy = -kRefineReach; dy <= kRefineReach; ++dy)
        for (int dx = -kRefineReach; dx <= kRefineReach; ++dx) {
          const double value = matcher.At(middle.x() + dx, middle.y() + dy);
          if (value <= best.correlation) continue;
          best.correlation = value;
          best.turn = tried;
          best.shift = (middle + Eigen::Vector2i(dx, dy)).cast<double>();
        }
    }
    best.found = best.correlation >= search.least_correlation;
  }
  return found;
}

}  // namespace keypose::fit
