#include "texture/packing/nesting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "texture/packing/stamps.h"

namespace keypose::texture {
namespace {

constexpr int kFirstTurns = 16;  // of the bottom-left start
constexpr double kScaleStep = 1.012;
constexpr double kLeastGrowth = 1.002;
constexpr int kPatience = 60;  // sweeps at one scale
constexpr int kMovesPerEffort = 16;
constexpr int kFar = 50;   // samples anywhere
constexpr int kNear = 16;  // samples near the present place
constexpr int kDescents = 3;

struct Random {
  std::uint64_t state;
  std::uint64_t Next() {  // splitmix64
    std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  int Below(int n) { return n > 0 ? static_cast<int>(Next() % static_cast<std::uint64_t>(n)) : 0; }
  int Between(int low, int high) { return low + Below(high - low + 1); }
};

// The rotation with the smallest bounding box, in steps of a degree and a half.
double LaidAngle(const UvsX2& points) {
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 60; ++step) {
    const double angle = step * kPi / 120;
    const UvsX2 turned = Turned(points, angle);
    const double box = (turned.colwise().maxCoeff() - turned.colwise().minCoeff()).prod();
    if (box >= least * (1 - 1e-9)) continue;
    least = box;
    best = angle;
  }
  return best;
}

double AreaOf(const UvsX2& p) {
  double sum = 0;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Eigen::Index j = (i + 1) % p.rows();
    sum += p(i, 0) * p(j, 1) - p(j, 0) * p(i, 1);
  }
  return sum / 2;
}

class NestingSearch {
 public:
  NestingSearch(const std::vector<UvsX2>& laid, const NestingOptions& options, std::uint64_t seed)
      : laid_(laid),
        n_(options.cells),
        widen_(options.gap / 2 * options.cells + options.margin),
        moves_(static_cast<std::int64_t>(options.effort) * kMovesPerEffort),
        random_{seed},
        by_area_(seed % 2) {
    for (const UvsX2& p : laid) area_ += AreaOf(p);
    order_.resize(laid.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::vector<double> size;
    for (const UvsX2& p : laid) {
      const Eigen::RowVector2d extent = p.colwise().maxCoeff() - p.colwise().minCoeff();
      size.push_back(by_area_ ? AreaOf(p) : extent.maxCoeff());
    }
    std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return size[a] > size[b]; });
  }

  double Run() {
    Start();
    if (best_.empty() || laid_.size() < 2) return scale_;
    double growth = kScaleStep;
    while (moves_ > 0 && growth > kLeastGrowth) {
      std::vector<Spot> spots = best_;
      if (Separated(scale_ * growth, spots)) {
        best_ = spots;
        scale_ *= growth;
      } else {
        growth = 1 + (growth - 1) * 0.6;
      }
    }
    return scale_;
  }

  double scale() const { return scale_; }  // cells per unit
  std::vector<Placement> Places(const std::vector<double>& laid_angles) {
    Stamps stamps(laid_, scale_, widen_);
    std::vector<Placement> places;
    for (int i = 0; i < std::ssize(laid_); ++i) {
      const Spot& spot = best_[i];
      const Stamp& stamp = stamps.Get(i, spot.turn);
      places.push_back({laid_angles[i] + 2 * kPi * spot.turn / kTurns,
                        (Eigen::Vector2d(spot.x, spot.y) - stamp.low) / n_});
    }
    return places;
  }

 private:
  // Bottom-left at decreasing scales, then bisection.
  void Start() {
    const double high_limit = n_ * std::sqrt(1 / area_);
    double low = 0, high = high_limit;
    for (double scale = high * 0.96, least = 0.02 * high_limit; scale > least; scale *= 0.93) {
      if (BottomLeft(scale)) {
        low = scale;
        break;
      }
      high = scale;
    }
    for (int round = 0; low > 0 && round < 4; ++round) {
      const double middle = (low + high) / 2;
      (BottomLeft(middle) ? low : high) = middle;
    }
    scale_ = low;
  }

  bool BottomLeft(double scale) {
    Stamps stamps(laid_, scale, widen_);
    std::int64_t cells = 0;
    for (const int item : order_) cells += stamps.Get(item, 0).cells;
    if (cells > static_cast<std::int64_t>(n_) * n_) return false;
    OccupiedCells taken(n_);
    std::vector<Spot> spots(laid_.size());
    for (const int item : order_) {
      double best = std::numeric_limits<double>::infinity();
      for (int turn = 0; turn < kTurns; turn += kTurns / kFirstTurns) {
        const Stamp& stamp = stamps.Get(item, turn);
        for (int y = 0; y + stamp.height <= n_ && y + stamp.height < best; ++y) {
          const int x = taken.FirstFree(stamp, 0, y);
          if (x < 0) continue;
          best = y + stamp.height + static_cast<double>(x) / (2 * n_);
          spots[item] = {turn, x, y};
          break;
        }
      }
      if (!(best < std::numeric_limits<double>::infinity())) return false;
      taken.Add(stamps.Get(item, spots[item].turn), spots[item].x, spots[item].y);
    }
    best_ = spots;
    return true;
  }

  // Prefix sums along the rows of the item's cost for overlapping each cell.
  void BuildCosts(int item, const std::vector<Spot>& spots, Stamps& stamps) {
    const int stride = n_ + 1, count = SizeOf(spots);
    costs_.assign(static_cast<std::size_t>(stride) * n_, 0);
    for (int j = 0; j < count; ++j) {
      if (j == item) continue;
      const int weight = static_cast<int>(weights_[static_cast<std::size_t>(item) * count + j]);
      for (const Stamp::Span& span : stamps.Get(j, spots[j].turn).spans) {
        std::int32_t* row =
            &costs_[static_cast<std::size_t>(spots[j].y + span.row) * stride + spots[j].x];
        row[span.begin + 1] += weight;
        if (spots[j].x + span.end < n_) row[span.end + 1] -= weight;
      }
    }
    for (int y = 0; y < n_; ++y) {
      std::int32_t* row = &costs_[static_cast<std::size_t>(y) * stride];
      std::int32_t value = 0, sum = 0;
      for (int x = 1; x <= n_; ++x) {
        value += row[x];
        sum += value;
        row[x] = sum;
      }
    }
  }

  // Stops as soon as it exceeds `limit`.
  std::int64_t Cost(const Stamp& stamp, int x, int y, std::int64_t limit) const {
    std::int64_t cost = 0;
    const std::int32_t* base = &costs_[static_cast<std::size_t>(y) * (n_ + 1) + x];
    for (const Stamp::Span& span : stamp.spans) {
      const std::int32_t* row = base + static_cast<std::size_t>(span.row) * (n_ + 1);
      cost += row[span.end] - row[span.begin];
      if (cost > limit) return cost;
    }
    return cost;
  }

  std::optional<Spot> Clamped(int item, Spot spot, Stamps& stamps) const {
    spot.turn = (spot.turn % kTurns + kTurns) % kTurns;
    const Stamp& stamp = stamps.Get(item, spot.turn);
    if (stamp.width > n_ || stamp.height > n_) return std::nullopt;
    spot.x = std::clamp(spot.x, 0, n_ - stamp.width);
    spot.y = std::clamp(spot.y, 0, n_ - stamp.height);
    return spot;
  }

  struct Candidate {
    std::int64_t cost;
    Spot spot;
  };

  // Descent with halving step sizes.
  void Descend(int item, Candidate& c, Stamps& stamps) const {
    for (int step = 8; step >= 1 && c.cost > 0; step /= 2) {
      for (bool better = true; better && c.cost > 0;) {
        better = false;
        const int turn = std::max(1, step / 2);
        const std::array<Spot, 6> moves = {{{0, step, 0},
                                            {0, -step, 0},
                                            {0, 0, step},
                                            {0, 0, -step},
                                            {turn, 0, 0},
                                            {-turn, 0, 0}}};
        for (const Spot& move : moves) {
          Spot next{c.spot.turn + move.turn, c.spot.x + move.x, c.spot.y + move.y};
          if (move.turn) {  // about the centre, not the corner of the box
            const Stamp &old = stamps.Get(item, c.spot.turn),
                        &now = stamps.Get(item, ((next.turn % kTurns) + kTurns) % kTurns);
            next.x += (old.width - now.width) / 2;
            next.y += (old.height - now.height) / 2;
          }
          const std::optional<Spot> spot = Clamped(item, next, stamps);
          if (!spot) continue;
          const std::int64_t cost = Cost(stamps.Get(item, spot->turn), spot->x, spot->y, c.cost);
          if (cost >= c.cost) continue;
          c = {cost, *spot};
          better = true;
        }
      }
    }
  }

  void Move(int item, std::vector<Spot>& spots, Stamps& stamps) {
    BuildCosts(item, spots, stamps);
    constexpr std::int64_t kAny = std::numeric_limits<std::int64_t>::max();
    std::vector<Candidate> found;
    const auto take = [&](const std::optional<Spot>& spot) {
      if (!spot) return;
      const std::int64_t limit = SizeOf(found) < kDescents ? kAny : found.back().cost;
      const std::int64_t cost = Cost(stamps.Get(item, spot->turn), spot->x, spot->y, limit);
      if (cost >= limit) return;
      found.push_back({cost, *spot});
      std::stable_sort(found.begin(), found.end(),
                       [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
      if (SizeOf(found) > kDescents) found.pop_back();
    };
    const Spot here = spots[item];
    const std::optional<Spot> stay = Clamped(item, here, stamps);
    for (int s = 0; s < kFar; ++s)
      take(Clamped(item, {random_.Below(kTurns), random_.Below(n_), random_.Below(n_)}, stamps));
    for (int s = 0; s < kNear; ++s)
      take(Clamped(item,
                   {here.turn + random_.Between(-3, 3), here.x + random_.Between(-12, 12),
                    here.y + random_.Between(-12, 12)},
                   stamps));
    if (stay) found.push_back({Cost(stamps.Get(item, stay->turn), stay->x, stay->y, kAny), *stay});
    if (found.empty()) return;
    for (Candidate& c : found) Descend(item, c, stamps);
    spots[item] =
        std::min_element(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
          return a.cost < b.cost;
        })->spot;
  }

  int Overlap(const Stamp& a, const Spot& at_a, const Stamp& b, const Spot& at_b) const {
    if (at_a.x + a.width <= at_b.x || at_b.x + b.width <= at_a.x || at_a.y + a.height <= at_b.y ||
        at_b.y + b.height <= at_a.y)
      return 0;
    int cells = 0;
    std::size_t first = 0;
    for (const Stamp::Span& s : a.spans) {
      const int y = at_a.y + s.row;
      while (first < b.spans.size() && at_b.y + b.spans[first].row < y) ++first;
      for (std::size_t j = first; j < b.spans.size() && at_b.y + b.spans[j].row == y; ++j)
        cells += std::max(0, std::min(at_a.x + s.end, at_b.x + b.spans[j].end) -
                                 std::max(at_a.x + s.begin, at_b.x + b.spans[j].begin));
    }
    return cells;
  }

  // Converts spots of the present scale to another, with the centre fixed. False if an outline is
  // larger than the square.
  bool Rescaled(double scale, std::vector<Spot>& spots, Stamps& stamps) const {
    const double ratio = scale / scale_;
    for (int i = 0; i < std::ssize(spots); ++i) {
      const Eigen::Vector2d grown =
          (Eigen::Vector2d(spots[i].x, spots[i].y) * ratio).array() - 0.5 * (ratio - 1) * n_;
      const Spot moved{spots[i].turn, static_cast<int>(std::lround(grown.x())),
                       static_cast<int>(std::lround(grown.y()))};
      const std::optional<Spot> spot = Clamped(i, moved, stamps);
      if (!spot) return false;
      spots[i] = *spot;
    }
    return true;
  }

  // The items that overlap; the weights of pairs increase as long as they overlap.
  std::vector<int> Overlapping(const std::vector<Spot>& spots, Stamps& stamps) {
    const int count = SizeOf(spots);
    std::vector<int> overlap(static_cast<std::size_t>(count) * count, 0);
    std::vector<char> moves(count, 0);
    int worst = 0;
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < i; ++j) {
        const int cells =
            Overlap(stamps.Get(i, spots[i].turn), spots[i], stamps.Get(j, spots[j].turn), spots[j]);
        overlap[static_cast<std::size_t>(i) * count + j] = cells;
        worst = std::max(worst, cells);
        if (cells) moves[i] = moves[j] = 1;
      }
    }
    for (int i = 0; worst > 0 && i < count; ++i) {
      for (int j = 0; j < i; ++j) {
        const int cells = overlap[static_cast<std::size_t>(i) * count + j];
        double& weight = weights_[static_cast<std::size_t>(i) * count + j];
        weight = cells ? std::min(weight * (1.2 + 0.8 * cells / worst), 2e4)
                       : std::max(16.0, weight * 0.95);
        weights_[static_cast<std::size_t>(j) * count + i] = weight;
      }
    }
    std::vector<int> items;
    for (int i = 0; i < count; ++i)
      if (moves[i]) items.push_back(i);
    return items;
  }

  // Moves overlapping items until none overlaps, or the limit of sweeps is reached.
  bool Separated(double scale, std::vector<Spot>& spots) {
    Stamps stamps(laid_, scale, widen_);
    if (!Rescaled(scale, spots, stamps)) return false;
    weights_.assign(spots.size() * spots.size(), 16);
    for (int sweep = 0; sweep < kPatience && moves_ > 0; ++sweep) {
      std::vector<int> items = Overlapping(spots, stamps);
      if (items.empty()) return true;
      for (int k = SizeOf(items); k > 1; --k) std::swap(items[k - 1], items[random_.Below(k)]);
      for (const int item : items) Move(item, spots, stamps);
      moves_ -= std::ssize(items);
    }
    return false;
  }

  const std::vector<UvsX2>& laid_;
  int n_;
  double widen_, area_ = 0, scale_ = 0;
  std::int64_t moves_;
  Random random_;
  bool by_area_;
  std::vector<int> order_;
  std::vector<Spot> best_;
  std::vector<double> weights_;
  std::vector<std::int32_t> costs_;
};

}  // namespace

Nesting Nested(const std::vector<UvsX2>& outlines, const NestingOptions& options) {
  std::vector<UvsX2> laid;
  std::vector<double> angles;
  for (const UvsX2& p : outlines) {
    angles.push_back(LaidAngle(p));
    laid.push_back(Turned(p, angles.back()));
  }
  std::vector<NestingSearch> searches;
  for (int s = 0; s < options.searches; ++s)
    searches.emplace_back(laid, options, static_cast<std::uint64_t>(s));
  ParallelFor(options.searches, [&](std::int64_t s) { searches[s].Run(); });
  int best = 0;
  for (int s = 1; s < options.searches; ++s)
    if (searches[s].scale() > searches[best].scale()) best = s;
  Nesting nesting;
  if (!(searches[best].scale() > 0)) return nesting;
  nesting.scale = searches[best].scale() / options.cells;
  nesting.places = searches[best].Places(angles);
  return nesting;
}

}  // namespace keypose::texture
