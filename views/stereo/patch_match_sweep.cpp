#include "views/stereo/patch_match_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "views/stereo/patch_match_areas.h"
#include "views/stereo/patch_match_lanes.h"
#include "views/stereo/patch_match_random.h"

namespace keypose::stereo {
namespace {

// No record of the data: kCostCap, kGeometricWeight and kGeometricCap are starting values, and none
// has changed since the first version; tests are on rendered balls and planes. Sensitivity:
// docs/results/sensitivity.md.
struct SweepTuning {
  // of a source, in units of 1 - correlation, so that a single source with a highlight or an
  // occluder cannot exclude a plane
  KEYPOSE_TUNED(float, kCostCap, 1.2f);
  // cost per pixel of distance from a source's own depth
  KEYPOSE_TUNED(float, kGeometricWeight, 0.2f);
  KEYPOSE_TUNED(float, kGeometricCap, 3.0f);  // px; larger distances cost no more
  // weight of the distance from the coarser level's depth, where a window has no texture
  KEYPOSE_TUNED(float, kPriorWeight, 0.3f);
  KEYPOSE_TUNED(float, kColorScale, 18.0f);  // grey levels at which a sample's weight falls to 1/e
};

constexpr float kPairMargin = 0.02f;  // a plane whose cost in the first two sources exceeds the
                                      // present one's by this is rejected
constexpr float kSame = 0.1f, kSameInTheEnd = 0.15f;  // pixels
constexpr int kStripWidth = 64;  // width of strips in which pixels are visited: the source pixels
                                 // that their windows read stay in the L1 cache
constexpr float kLeastCosine = 0.17f;  // planes slanted by more than 80 degrees are rejected
constexpr float kInfinite = std::numeric_limits<float>::infinity();

class Sweeper {
 public:
  Sweeper(const SweepInputs& inputs, const SweepSettings& settings, PlaneMap* map)
      : in_(inputs),
        set_(settings),
        map_(*map),
        image_(inputs.reference->levels[inputs.level].grey),
        camera_(inputs.reference->camera(inputs.level)),
        cost_(BestPatchCostKernel().cost),
        geometric_(!inputs.source_inverse_depths.empty()),
        count_(static_cast<int>(std::min<std::size_t>(inputs.sources.size(), kMaxSources))) {
    for (int k = 0; k < count_; ++k) {
      to_source_[k] = MakeTransfer(*in_.reference, *in_.sources[k], in_.level);
      from_source_[k] = MakeTransfer(*in_.sources[k], *in_.reference, in_.level);
    }
    for (int k = 0; k < count_; k += kLanes)
      all_.push_back(LanesOf(((1u << kLanes) - 1) << k & ((1u << count_) - 1)));
    for (int quarter = 0; quarter < 4; ++quarter) {
      areas_.push_back(Turned(kNear, quarter, map_.width));
      if (set_.far_areas) areas_.push_back(Turned(kFar, quarter, map_.width));
    }
    px_per_inverse_depth_ = static_cast<float>(PixelsPerInverseDepth(inputs));
  }

  std::int64_t Run() {
    for (int color = 0; color < 2; ++color)
      for (int left = 0; left < map_.width; left += kStripWidth)
        VisitStrip(left, std::min(left + kStripWidth, map_.width), color);
    return evaluations_;
  }

 private:
  struct Bounds {
    float nearest, farthest;
  };

  SourceLanes LanesOf(unsigned sources) const {
    SourceLanes lanes;
    for (int k = 0; k < count_ && lanes.count < kLanes; ++k)
      if (sources >> k & 1) lanes.ids[lanes.count++] = k;
    for (int lane = 0; lane < kLanes; ++lane) {
      const int k = lanes.ids[lane < lanes.count ? lane : 0];
      lanes.ids[lane] = k;
      lanes.to.Set(lane, to_source_[k]);
      lanes.from.Set(lane, from_source_[k]);
      lanes.images[lane] = in_.samples[k];
      if (!geometric_) continue;
      const DepthImage& depths = *in_.source_inverse_depths[k];
      lanes.depths[lane] = &depths;
      lanes.depth_stride[lane] = depths.width;
      lanes.depth_width[lane] = static_cast<float>(depths.width);
      lanes.depth_height[lane] = static_cast<float>(depths.height);
    }
    return lanes;
  }

  void VisitStrip(int left, int right, int color) {
    for (int y = 0; y < map_.height; ++y)
      for (int x = left + ((y + color + left) & 1); x < right; x += 2)
        if (map_.InverseDepth(Index(x, y)) > 0) Visit(x, y);
  }

  std::size_t Index(int x, int y) const { return static_cast<std::size_t>(y) * map_.width + x; }

  Bounds BoundsAt(int x, int y) const {
    const DepthBounds& b = *in_.bounds;
    const int shift = b.shift - in_.level;
    const int bx = std::min(x >> shift, b.nearest.width - 1),
              by = std::min(y >> shift, b.nearest.height - 1);
    return {*b.nearest.at(bx, by), *b.farthest.at(bx, by)};
  }

  bool Legal(const PlaneHypothesis& plane) const {
    if (!(plane.inverse_depth >= bounds_.farthest && plane.inverse_depth <= bounds_.nearest))
      return false;
    const float nx = static_cast<float>(camera_.fx) * plane.gx,
                ny = static_cast<float>(camera_.fy) * plane.gy;
    const float nz = plane.inverse_depth - ray_x_ * nx - ray_y_ * ny;
    return plane.inverse_depth * plane.inverse_depth >=
           kLeastCosine * kLeastCosine * ray_length2_ * (nx * nx + ny * ny + nz * nz);
  }

  // A narrow window averages the depth of a curved surface over a smaller area and covers fewer
  // edges; a wide one has more texture. The choice depends on the reference picture alone, so it is
  // the same in all passes of a level.
  void ChooseWindow(int x, int y) {
    window_ = Window::kNarrow;
    if (in_.narrow_variance < kInfinite) {
      FillRefPatch(image_, x, y, bilateral_, in_.noise_variance, &patch_, window_);
      if (patch_.variance >= in_.narrow_variance) return;
    }
    window_ = Window::kWide;
    FillRefPatch(image_, x, y, bilateral_, in_.noise_variance, &patch_, window_);
  }

  WarpLanes Warps(const TransferLanes& to, const PixelLanes& middle, PlaneHypothesis plane) const {
    plane.inverse_depth += WindowMiddle(window_) * (plane.gx + plane.gy);
    return WarpsOf(to, middle, plane, WindowScale(window_));
  }

  void Prepare(int x, int y) {
    ChooseWindow(x, y);
    x_ = static_cast<float>(x) + WindowMiddle(window_);
    y_ = static_cast<float>(y) + WindowMiddle(window_);
    ray_x_ = static_cast<float>((x - camera_.cx) / camera_.fx);
    ray_y_ = static_cast<float>((y - camera_.cy) / camera_.fy);
    ray_length2_ = ray_x_ * ray_x_ + ray_y_ * ray_y_ + 1;
    bounds_ = BoundsAt(x, y);
    prior_ = in_.prior ? PriorAt(*in_.prior, x, y, px_per_inverse_depth_) : 0;
    const float trust = patch_.variance / (patch_.variance + 9 * in_.noise_variance + 1e-6f);
    prior_weight_ = prior_ > 0 ? SweepTuning::kPriorWeight * (1 - trust) : 0;
  }

  // The forward-backward reprojection error: to each source by this plane, and back by the source's
  // own depth.
  Lanes GeometricCosts(const SourceLanes& lanes, const WarpLanes& warps) const {
    Lanes sx, sy, w{};
    std::memcpy(&sx, warps.x, sizeof sx);
    std::memcpy(&sy, warps.y, sizeof sy);
    const Lanes x = sx - 0.5f, y = sy - 0.5f;  // half a pixel on, without the border
    const LaneInts inside =
        (x >= 0.0f) & (y >= 0.0f) & (x < lanes.depth_width) & (y < lanes.depth_height);
    const LaneInts at =
        __builtin_convertvector(inside ? y : Lanes{}, LaneInts) * lanes.depth_stride +
        __builtin_convertvector(inside ? x : Lanes{}, LaneInts);
    for (int lane = 0; lane < kLanes; ++lane)
      w[lane] = lanes.depths[lane]->At(static_cast<std::size_t>(at[lane]));
    w = inside ? w : Lanes{};
    sx -= 1.0f;
    sy -= 1.0f;
    const TransferLanes& t = lanes.from;
    const Lanes inverse = 1.0f / (t.x[2] * sx + t.y[2] * sy + t.one[2] + t.depth[2] * w);
    const Lanes dx = (t.x[0] * sx + t.y[0] * sy + t.one[0] + t.depth[0] * w) * inverse - x_;
    const Lanes dy = (t.x[1] * sx + t.y[1] * sy + t.one[1] + t.depth[1] * w) * inverse - y_;
    const Lanes square = dx * dx + dy * dy,
                worst = Lanes{} + SweepTuning::kGeometricCap * SweepTuning::kGeometricCap;
    const Lanes used = (w > 0.0f) & (square < worst) ? square : worst;
    return SweepTuning::kGeometricWeight * SquareRoots(used);
  }

  float PriorCost(const PlaneHypothesis& plane) const {
    return prior_weight_ > 0
               ? prior_weight_ *
                     std::min(1.0f, std::abs(plane.inverse_depth - prior_) * px_per_inverse_depth_)
               : 0;
  }

  // Costs are means over the pixel's sources. All planes are first matched in the first two
  // sources, and only those that may still win are then matched in the others, one by one. A
  // window's result has a long latency, and a branch on it would stall the processor. Planes whose
  // costs without windows are already too large are dropped first.
  // @return number of remaining planes
  int StartTrials(int count, float limit) {
    const int pair = std::min(2, chosen_.count);
    const float scale = 1.0f / static_cast<float>(chosen_.count);
    float costs[kLanes];
    for (int h = 0; h < count; ++h) trials_[h].warps = Warps(chosen_.to, pixel_, trials_[h].plane);
    int kept = 0;
    for (int h = 0; h < count; ++h) {
      Trial& trial = trials_[h];
      trial.sum = PriorCost(trial.plane);
      if (geometric_) {
        const Lanes geometric = GeometricCosts(chosen_, trial.warps);
        for (int k = 0; k < chosen_.count; ++k) trial.sum += geometric[k] * scale;
      }
      trial.extra = trial.sum;
      if (trial.sum >= limit) continue;
      if (kept != h) trials_[kept] = trial;
      ++kept;
    }
    for (int h = 0; h < kept; ++h) {
      cost_(patch_, chosen_.images, trials_[h].warps, 0, pair, costs);
      for (int k = 0; k < pair; ++k)
        trials_[h].sum += std::min(costs[k], SweepTuning::kCostCap) * scale;
      trials_[h].pair = trials_[h].sum;
    }
    evaluations_ += static_cast<std::int64_t>(kept) * pair;
    return kept;
  }

  void FinishTrial(Trial* trial) {
    const int rest = chosen_.count - 2;
    if (rest <= 0) return;
    const float scale = 1.0f / static_cast<float>(chosen_.count);
    float costs[kLanes];
    cost_(patch_, chosen_.images, trial->warps, 2, rest, costs);
    for (int k = 2; k < 2 + rest; ++k)
      trial->sum += std::min(costs[k], SweepTuning::kCostCap) * scale;
    evaluations_ += rest;
  }

  void Contest(int count, PlaneHypothesis* plane, float* cost) {
    const int kept = StartTrials(count, *cost);
    for (int h = 0; h < kept; ++h) {
      if (trials_[h].sum >= *cost || trials_[h].pair > pair_ + kPairMargin) continue;
      FinishTrial(&trials_[h]);
      if (trials_[h].sum < *cost) {
        *plane = trials_[h].plane;
        *cost = trials_[h].sum;
        pair_ = trials_[h].pair;
        extra_ = trials_[h].extra;
      }
    }
  }

  // The best plane of each area, moved to (x, y).
  void CollectCandidates(int x, int y) {
    candidates_ = 0;
    const int reach = set_.far_areas ? kFarReach : kNearReach;
    const bool inner =
        x >= reach && y >= reach && x + reach < map_.width && y + reach < map_.height;
    for (const Area& area : areas_) Collect(x, y, area, inner);
  }

  void Collect(int x, int y, const Area& area, bool inner) {
    const std::size_t here = Index(x, y);
    // Cost and index in one number: finding its minimum needs no branch, which would be
    // mispredicted half of the time.
    std::uint32_t least = static_cast<std::uint32_t>(PlaneMap::kNoCost) << 4;
    const int count = SizeOf(area.steps);
    for (int i = 0; i < count; ++i) {
      if (!inner) {
        const int nx = x + area.offsets[i].dx, ny = y + area.offsets[i].dy;
        if (nx < 0 || ny < 0 || nx >= map_.width || ny >= map_.height) continue;
      }
      least =
          std::min(least, static_cast<std::uint32_t>(map_.PackedCost(here + area.steps[i])) << 4 |
                              static_cast<std::uint32_t>(i));
    }
    if (least >> 4 == PlaneMap::kNoCost) return;
    const std::size_t best = least & 15;
    PlaneHypothesis plane = map_.Plane(here + area.steps[best]);
    plane.inverse_depth -= static_cast<float>(area.offsets[best].dx) * plane.gx +
                           static_cast<float>(area.offsets[best].dy) * plane.gy;
    if (Same(plane, present_) || !Legal(plane)) return;
    for (int i = 0; i < candidates_; ++i)
      if (Same(plane, candidate_[i])) return;
    candidate_[candidates_++] = plane;
  }

  // Planes that differ by less than a fraction of a pixel over the window. The parabola resolves
  // smaller depth differences.
  bool Same(const PlaneHypothesis& a, const PlaneHypothesis& b) const {
    const float change = std::abs(a.inverse_depth - b.inverse_depth) +
                         kPatchRadius * (std::abs(a.gx - b.gx) + std::abs(a.gy - b.gy));
    return change * px_per_inverse_depth_ < (set_.parabola ? kSameInTheEnd : kSame);
  }

  // A source that matches several candidates sees this pixel; a source that matches none is
  // occluded.
  void SelectSources(std::size_t index) {
    candidate_[candidates_] = present_;
    const int total = candidates_ + 1;
    for (int h = 0; h < total; ++h) FillRow(candidate_[h], matrix_[h]);
    std::array<float, kMaxSources> score{};
    const unsigned before = map_.Sources(index);
    for (int k = 0; k < count_; ++k) {
      float least = kInfinite;
      for (int h = 0; h < total; ++h) {
        const float m = matrix_[h][k];
        least = std::min(least, m);
        if (m < 0.8f) score[k] += std::exp(-m * m / 0.18f);
      }
      if (before >> k & 1) score[k] *= 1.25f;
      score[k] -= 1e-3f * least;  // ranks the sources when no candidate is good
    }
    std::uint16_t chosen = 0;
    for (int n = 0; n < std::min(kSourcesUsed, count_); ++n) {
      int best = -1;
      for (int k = 0; k < count_; ++k)
        if (!(chosen >> k & 1) && (best < 0 || score[k] > score[best])) best = k;
      if (n >= 2 && score[best] <= 0) break;
      chosen |= static_cast<std::uint16_t>(1 << best);
    }
    map_.SetSources(index, chosen);
  }

  void FillRow(const PlaneHypothesis& plane, float* row) {
    for (const SourceLanes& lanes : all_) {
      float costs[kLanes];
      cost_(patch_, lanes.images, Warps(lanes.to, AtPixel(lanes.to, x_, y_), plane), 0, lanes.count,
            costs);
      evaluations_ += lanes.count;
      for (int k = 0; k < lanes.count; ++k)
        row[lanes.ids[k]] = std::min(costs[k], SweepTuning::kCostCap);
    }
  }

  void Choose(std::uint16_t sources) {
    if (sources != chosen_bits_) chosen_ = LanesOf(sources);
    chosen_bits_ = sources;
    pixel_ = AtPixel(chosen_.to, x_, y_);
  }

  // For a candidate whose windows in all sources are known.
  void JudgeRow(int h, PlaneHypothesis* plane, float* cost) {
    const float scale = 1.0f / static_cast<float>(chosen_.count), extra = PriorCost(candidate_[h]);
    float sum = extra, pair = extra;
    for (int k = 0; k < chosen_.count; ++k) {
      sum += matrix_[h][chosen_.ids[k]] * scale;
      if (k < 2) pair = sum;
    }
    if (sum < *cost) {
      *plane = candidate_[h];
      *cost = sum;
      pair_ = pair;
      extra_ = extra;
    }
  }

  // The present plane's window costs are known from the pass before; its geometric costs may have
  // changed.
  void Recall(std::size_t index, const PlaneHypothesis& plane, float* cost) {
    extra_ = PriorCost(plane);
    if (geometric_) {
      const Lanes geometric = GeometricCosts(chosen_, Warps(chosen_.to, pixel_, plane));
      for (int k = 0; k < chosen_.count; ++k)
        extra_ += geometric[k] / static_cast<float>(chosen_.count);
    }
    const PlaneMap::Match match = map_.MatchOf(index);
    *cost = match.all + extra_;
    pair_ = match.pair + extra_;
  }

  void Visit(int x, int y) {
    const std::size_t index = Index(x, y);
    Prepare(x, y);
    present_ = map_.Plane(index);
    CollectCandidates(x, y);
    PlaneHypothesis plane = present_;
    float cost = kInfinite;
    pair_ = kInfinite;
    extra_ = 0;
    if (set_.select_sources) {
      SelectSources(index);
      Choose(map_.Sources(index));
      for (int h = candidates_; h >= 0; --h) JudgeRow(h, &plane, &cost);
    } else {
      Choose(map_.Sources(index));
      if (set_.refresh) {
        trials_[0].plane = plane;
        Contest(1, &plane, &cost);
      } else {
        Recall(index, plane, &cost);
      }
      int trials = 0;
      for (int h = 0; h < candidates_; ++h) trials_[trials++].plane = candidate_[h];
      Contest(trials, &plane, &cost);
    }
    Refine(x, y, &plane, &cost);
    map_.SetPlane(index, plane);
    map_.SetCost(index, cost);
    if (set_.parabola)
      map_.SetExpectedError(index, ExpectedError(plane));
    else
      map_.SetMatch(index, {cost - extra_, pair_ - extra_});
  }

  static void Accept(const PlaneHypothesis& candidate, float candidate_cost, PlaneHypothesis* plane,
                     float* cost) {
    if (candidate_cost < *cost) {
      *plane = candidate;
      *cost = candidate_cost;
    }
  }

  void Refine(int x, int y, PlaneHypothesis* plane, float* cost) {
    Random random(in_.seed ^ (static_cast<std::uint64_t>(set_.pass) << 48) ^
                  (static_cast<std::uint64_t>(in_.level) << 56) ^
                  (static_cast<std::uint64_t>(y) * 65536 + x) * 0xD6E8FEB86659FD93ull);
    const float depth_step = set_.depth_step_px / px_per_inverse_depth_;
    const float focal = static_cast<float>(camera_.fx);
    int trials = 0;
    for (int trial = 0; trial < set_.refinements; ++trial) {
      if (trial == 2) {
        Contest(trials, plane, cost);
        trials = 0;
      }  // the third change starts from the better of the first two
      PlaneHypothesis candidate = *plane;
      const int kind = (trial + (set_.parabola ? 1 : 0)) %
                       4;  // 0 depth, unless the parabola finds it; 1 tilt; 2 both; 3 random plane
      if (kind == 0 || kind == 2) candidate.inverse_depth += depth_step * random.Signed();
      if (kind == 1 || kind == 2) {
        // Tilts grow with the slant, because there the same angle is a larger tangent.
        const float unit = plane->inverse_depth / focal;
        const float slope2 = (plane->gx * plane->gx + plane->gy * plane->gy) / (unit * unit);
        const float step = set_.slope_step * unit * (1 + slope2);
        candidate.gx += step * random.Signed();
        candidate.gy += step * random.Signed();
      }
      if (kind == 3) {
        candidate.inverse_depth =
            bounds_.farthest + (bounds_.nearest - bounds_.farthest) * random.Unit();
        candidate.gx = candidate.inverse_depth / focal * 1.5f * random.Signed();
        candidate.gy = candidate.inverse_depth / focal * 1.5f * random.Signed();
      }
      if (Legal(candidate)) trials_[trials++].plane = candidate;
    }
    Contest(trials, plane, cost);
    if (set_.parabola) Settle(plane, cost);
  }

  // Moves the depth to the minimum of the parabola through the costs at a quarter of a pixel
  // nearer, here, and a quarter farther.
  void Settle(PlaneHypothesis* plane, float* cost) {
    const float step = 0.25f / px_per_inverse_depth_, here = *cost;
    trials_[0].plane = trials_[1].plane = *plane;
    trials_[0].plane.inverse_depth += step;
    trials_[1].plane.inverse_depth -= step;
    StartTrials(2, kInfinite);
    FinishTrial(&trials_[0]);
    FinishTrial(&trials_[1]);
    const float nearer = trials_[0].sum, farther = trials_[1].sum,
                bend = nearer + farther - 2 * here;
    window_cost_ = here - extra_;
    window_bend_ = bend - (trials_[0].extra + trials_[1].extra - 2 * extra_);
    const PlaneHypothesis center = *plane;
    for (int h = 0; h < 2; ++h)
      if (Legal(trials_[h].plane)) Accept(trials_[h].plane, trials_[h].sum, plane, cost);
    if (!(bend > 1e-4f)) return;
    PlaneHypothesis lowest = center;
    lowest.inverse_depth += step * std::clamp(0.5f * (farther - nearer) / bend, -1.0f, 1.0f);
    if (Legal(lowest)) *plane = lowest;  // no windows needed: the parabola gives the cost
  }

  // Two windows of variance V that differ by noise of variance r have the cost r / (2 V) at the
  // best shift, and u^2 g / (2 V) more at a distance of u pixels, where g is the mean squared
  // gradient. Least squares over n samples estimates the shift with the variance r / (n g). So cost
  // over curvature is the squared error, for any kind of noise: the sensor's, or a highlight's.
  // [pixels of this view on the surface]
  float ExpectedError(const PlaneHypothesis& plane) const {
    constexpr float kStep = 0.25f,
                    // half of the window's samples: weights differ, and noise is not white
        kSamples = 16;
    if (patch_.variance < 4 * in_.noise_variance) return kInfinite;  // no texture above the noise
    const float px = kStep * std::sqrt(2 * std::max(window_cost_, 1e-3f) /
                                       (kSamples * std::max(window_bend_, 1e-6f)));
    return px / px_per_inverse_depth_ * static_cast<float>(camera_.fx) / plane.inverse_depth;
  }

  const SweepInputs& in_;
  const SweepSettings& set_;
  PlaneMap& map_;
  const GreyMask& image_;
  const Pinhole camera_;
  const PatchCostFunction cost_;
  const bool geometric_;
  const BilateralTable bilateral_{SweepTuning::kColorScale};
  const int count_;
  float px_per_inverse_depth_ = 1;
  std::array<Transfer, kMaxSources> to_source_, from_source_;
  std::vector<SourceLanes> all_;
  std::vector<Area> areas_;
  std::int64_t evaluations_ = 0;

  // State of the visited pixel.
  RefPatch patch_;
  Window window_ = Window::kWide;
  float x_ = 0, y_ = 0;  // the window's middle
  float ray_x_ = 0, ray_y_ = 0, ray_length2_ = 1, prior_ = 0, prior_weight_ = 0;
  Bounds bounds_{};
  unsigned chosen_bits_ = 0;
  SourceLanes chosen_;
  PixelLanes pixel_{};
  PlaneHypothesis present_;
  float extra_ = 0, window_cost_ = 0, window_bend_ = 0;
  // cost of the present plane in the first two sources, where known
  float pair_ = kInfinite;
  int candidates_ = 0;
  std::array<PlaneHypothesis, 9> candidate_;
  float matrix_[9][kMaxSources];
  std::array<Trial, 10> trials_;
};

}  // namespace

std::int64_t Sweep(const SweepInputs& inputs, const SweepSettings& settings, PlaneMap* map) {
  return Sweeper(inputs, settings, map).Run();
}

}  // namespace keypose::stereo
