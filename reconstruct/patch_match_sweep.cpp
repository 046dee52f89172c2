#include "reconstruct/patch_match_sweep.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace keypose::reconstruct {
namespace {

constexpr float kCostCap = 1.2f;          // one source that sees a highlight or an occluder must not veto
constexpr float kGeometricWeight = 0.2f;  // cost per pixel of disagreement with a source's own depth
constexpr float kGeometricCap = 3.0f;     // pixels
constexpr float kPriorWeight = 0.3f;
constexpr float kLeastCosine = 0.17f;  // planes more slanted than 80 degrees are not worth a window
constexpr float kInfinite = std::numeric_limits<float>::infinity();

// Small, fast, and a pure function of its seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  float Signed() { return static_cast<float>(static_cast<std::int64_t>(Next() >> 40) - (1 << 23)) * (1.0f / (1 << 23)); }
  float Unit() { return static_cast<float>(Next() >> 40) * (1.0f / (1 << 24)); }

 private:
  std::uint64_t Next() {  // splitmix64
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

// source pixel ~ a * (x, y, 1) + b * inverse depth.
struct Transfer {
  Eigen::Matrix3f a;
  Eigen::Vector3f b;
};

Transfer MakeTransfer(const DenseView& from, const DenseView& to, int level) {
  const Rigid3 to_from = Compose(to.camera_from_world, from.camera_from_world.Inverse());
  const Eigen::Matrix3d k = to.camera(level).K();
  return {(k * to_from.rotation.toRotationMatrix() * from.camera(level).K().inverse()).cast<float>(),
          (k * to_from.translation).cast<float>()};
}

struct Offset {
  int dx, dy;
};

// Pixels of the other colour, up; the other directions are turns of these.
constexpr std::array<Offset, 7> kNear = {{{0, -1}, {-1, -2}, {1, -2}, {-2, -3}, {2, -3}, {-3, -4}, {3, -4}}};
constexpr std::array<Offset, 11> kFar = {
    {{0, -3}, {0, -5}, {0, -7}, {0, -9}, {0, -11}, {0, -13}, {0, -15}, {0, -17}, {0, -19}, {0, -21}, {0, -23}}};

Offset Turned(Offset o, int quarter) {
  for (int i = 0; i < quarter; ++i) o = {-o.dy, o.dx};
  return o;
}

class Sweeper {
 public:
  Sweeper(const SweepInputs& inputs, const SweepSettings& settings, PlaneMap* map)
      : in_(inputs),
        set_(settings),
        map_(*map),
        image_(inputs.reference->levels[inputs.level].grey),
        camera_(inputs.reference->camera(inputs.level)),
        cost_(BestPatchCostKernel().cost),
        count_(static_cast<int>(std::min<std::size_t>(inputs.sources.size(), kMaxSources))) {
    for (int k = 0; k < count_; ++k) {
      to_source_[k] = MakeTransfer(*in_.reference, *in_.sources[k], in_.level);
      from_source_[k] = MakeTransfer(*in_.sources[k], *in_.reference, in_.level);
      source_images_[k] = &in_.sources[k]->levels[in_.level].grey;
    }
    px_per_inverse_depth_ = static_cast<float>(PixelsPerInverseDepth(inputs));
  }

  std::int64_t Run() {
    for (int color = 0; color < 2; ++color)
      for (int y = 0; y < map_.height; ++y)
        for (int x = (y + color) & 1; x < map_.width; x += 2)
          if (map_.planes[Index(x, y)].inverse_depth > 0) Visit(x, y);
    return evaluations_;
  }

 private:
  struct Bounds {
    float nearest, farthest;
  };

  std::size_t Index(int x, int y) const { return static_cast<std::size_t>(y) * map_.width + x; }

  Bounds BoundsAt(int x, int y) const {
    const DepthBounds& b = *in_.bounds;
    const int shift = b.shift - in_.level;
    const int bx = std::min(x >> shift, b.nearest.width - 1), by = std::min(y >> shift, b.nearest.height - 1);
    return {*b.nearest.at(bx, by), *b.farthest.at(bx, by)};
  }

  bool Legal(int x, int y, const PlaneHypothesis& plane, const Bounds& bounds) const {
    if (!(plane.inverse_depth >= bounds.farthest && plane.inverse_depth <= bounds.nearest)) return false;
    const float rx = static_cast<float>((x - camera_.cx) / camera_.fx), ry = static_cast<float>((y - camera_.cy) / camera_.fy);
    const float nx = static_cast<float>(camera_.fx) * plane.gx, ny = static_cast<float>(camera_.fy) * plane.gy;
    const float nz = plane.inverse_depth - rx * nx - ry * ny;
    const float cosine2 = plane.inverse_depth * plane.inverse_depth / ((nx * nx + ny * ny + nz * nz) * (rx * rx + ry * ry + 1));
    return cosine2 >= kLeastCosine * kLeastCosine;
  }

  void Prepare(int x, int y) {
    FillRefPatch(image_, x, y, bilateral_, &patch_);
    const float fx = static_cast<float>(x), fy = static_cast<float>(y);
    for (int k = 0; k < count_; ++k) base_[k] = to_source_[k].a.col(0) * fx + to_source_[k].a.col(1) * fy + to_source_[k].a.col(2);
    prior_ = in_.prior ? *in_.prior->at(x, y) : 0;
    const float trust = patch_.variance / (patch_.variance + 9 * in_.noise_variance + 1e-6f);
    prior_weight_ = prior_ > 0 ? kPriorWeight * (1 - trust) : 0;
  }

  float SourceCost(int k, const PlaneHypothesis& plane) {
    PatchWarp warp;
    const Transfer& t = to_source_[k];
    for (int i = 0; i < 3; ++i) {
      warp.h0[i] = base_[k][i] + t.b[i] * plane.inverse_depth;
      warp.hx[i] = t.a(i, 0) + t.b[i] * plane.gx;
      warp.hy[i] = t.a(i, 1) + t.b[i] * plane.gy;
    }
    ++evaluations_;
    return std::min(cost_(patch_, *source_images_[k], warp, in_.noise_variance), kCostCap) + GeometricCost(k, warp);
  }

  // How far the pixel lands from itself when it goes to the source by this plane and comes back by the source's own depth.
  float GeometricCost(int k, const PatchWarp& warp) const {
    if (in_.source_inverse_depths.empty()) return 0;
    constexpr float kWorst = kGeometricWeight * kGeometricCap;
    const ImageF& depths = *in_.source_inverse_depths[k];
    const float sx = warp.h0[0] / warp.h0[2], sy = warp.h0[1] / warp.h0[2];
    if (!(warp.h0[2] > 0 && sx > -0.5f && sy > -0.5f && sx < depths.width - 0.5f && sy < depths.height - 0.5f)) return kWorst;
    const float w = *depths.at(static_cast<int>(sx + 0.5f), static_cast<int>(sy + 0.5f));
    if (!(w > 0)) return kWorst;
    const Eigen::Vector3f back = from_source_[k].a * Eigen::Vector3f(sx, sy, 1) + from_source_[k].b * w;
    const float dx = back.x() / back.z() - x_, dy = back.y() / back.z() - y_;
    const float distance = std::sqrt(dx * dx + dy * dy);
    return distance < kGeometricCap ? kGeometricWeight * distance : kWorst;
  }

  float PriorCost(const PlaneHypothesis& plane) const {
    return prior_weight_ > 0 ? prior_weight_ * std::min(1.0f, std::abs(plane.inverse_depth - prior_) * px_per_inverse_depth_) : 0;
  }

  // Mean over the pixel's sources; stops when it cannot get below `limit` any more.
  float Evaluate(const PlaneHypothesis& plane, std::uint16_t sources, float limit) {
    const float scale = 1.0f / static_cast<float>(std::popcount(sources));
    float sum = PriorCost(plane);
    for (int k = 0; k < count_; ++k) {
      if (!(sources >> k & 1)) continue;
      sum += SourceCost(k, plane) * scale;
      if (sum >= limit) return kInfinite;
    }
    return sum;
  }

  // The best plane of each area, moved to (x, y).
  void CollectCandidates(int x, int y, const Bounds& bounds) {
    candidates_ = 0;
    for (int quarter = 0; quarter < 4; ++quarter) {
      Collect(x, y, quarter, kNear.data(), static_cast<int>(kNear.size()), bounds);
      if (set_.far_areas) Collect(x, y, quarter, kFar.data(), static_cast<int>(kFar.size()), bounds);
    }
  }

  void Collect(int x, int y, int quarter, const Offset* offsets, int count, const Bounds& bounds) {
    float least = kInfinite;
    Offset best{};
    for (int i = 0; i < count; ++i) {
      const Offset o = Turned(offsets[i], quarter);
      const int nx = x + o.dx, ny = y + o.dy;
      if (nx < 0 || ny < 0 || nx >= map_.width || ny >= map_.height) continue;
      const float cost = map_.cost[Index(nx, ny)];
      if (cost < least) least = cost, best = o;
    }
    if (least == kInfinite) return;
    PlaneHypothesis plane = map_.planes[Index(x + best.dx, y + best.dy)];
    plane.inverse_depth -= best.dx * plane.gx + best.dy * plane.gy;
    if (!Legal(x, y, plane, bounds) || Same(plane, map_.planes[Index(x, y)])) return;
    for (int i = 0; i < candidates_; ++i)
      if (Same(plane, candidate_[i])) return;
    candidate_[candidates_++] = plane;
  }

  // Planes that differ by less than a twentieth of a pixel over the window.
  bool Same(const PlaneHypothesis& a, const PlaneHypothesis& b) const {
    const float change = std::abs(a.inverse_depth - b.inverse_depth) + kPatchRadius * (std::abs(a.gx - b.gx) + std::abs(a.gy - b.gy));
    return change * px_per_inverse_depth_ < 0.05f;
  }

  // Sources that agree with several candidates see this pixel; those that agree with none are hidden from it.
  void SelectSources(std::size_t index) {
    candidate_[candidates_] = map_.planes[index];
    const int total = candidates_ + 1;
    std::array<float, kMaxSources> score{};
    for (int k = 0; k < count_; ++k) {
      float least = kInfinite;
      for (int h = 0; h < total; ++h) {
        const float m = matrix_[h][k] = SourceCost(k, candidate_[h]);
        least = std::min(least, m);
        if (m < 0.8f) score[k] += std::exp(-m * m / 0.18f);
      }
      if (map_.sources[index] >> k & 1) score[k] *= 1.25f;
      score[k] -= 1e-3f * least;  // an order when nothing is good
    }
    std::uint16_t chosen = 0;
    for (int n = 0; n < std::min(kSourcesUsed, count_); ++n) {
      int best = -1;
      for (int k = 0; k < count_; ++k)
        if (!(chosen >> k & 1) && (best < 0 || score[k] > score[best])) best = k;
      if (n >= 2 && score[best] <= 0) break;
      chosen |= static_cast<std::uint16_t>(1 << best);
    }
    map_.sources[index] = chosen;
  }

  float MatrixCost(int h, std::uint16_t sources) const {
    float sum = 0;
    for (int k = 0; k < count_; ++k)
      if (sources >> k & 1) sum += matrix_[h][k];
    return sum / static_cast<float>(std::popcount(sources)) + PriorCost(candidate_[h]);
  }

  void Visit(int x, int y) {
    const std::size_t index = Index(x, y);
    x_ = static_cast<float>(x), y_ = static_cast<float>(y);
    Prepare(x, y);
    const Bounds bounds = BoundsAt(x, y);
    CollectCandidates(x, y, bounds);
    PlaneHypothesis& plane = map_.planes[index];
    float& cost = map_.cost[index];
    if (set_.select_sources) {
      SelectSources(index);
      cost = MatrixCost(candidates_, map_.sources[index]);
      for (int h = 0; h < candidates_; ++h) Accept(candidate_[h], MatrixCost(h, map_.sources[index]), &plane, &cost);
    } else {
      if (set_.refresh) cost = Evaluate(plane, map_.sources[index], kInfinite);
      for (int h = 0; h < candidates_; ++h) Accept(candidate_[h], Evaluate(candidate_[h], map_.sources[index], cost), &plane, &cost);
    }
    Refine(x, y, bounds, map_.sources[index], &plane, &cost);
  }

  static void Accept(const PlaneHypothesis& candidate, float candidate_cost, PlaneHypothesis* plane, float* cost) {
    if (candidate_cost < *cost) *plane = candidate, *cost = candidate_cost;
  }

  void Refine(int x, int y, const Bounds& bounds, std::uint16_t sources, PlaneHypothesis* plane, float* cost) {
    Random random(in_.seed ^ (static_cast<std::uint64_t>(set_.pass) << 48) ^ (static_cast<std::uint64_t>(in_.level) << 56) ^
                  (static_cast<std::uint64_t>(y) * 65536 + x) * 0xD6E8FEB86659FD93ull);
    const float depth_step = set_.depth_step_px / px_per_inverse_depth_;
    const float focal = static_cast<float>(camera_.fx);
    for (int trial = 0; trial < set_.refinements; ++trial) {
      PlaneHypothesis candidate = *plane;
      const int kind = trial % 4;  // depth, tilt, both, anywhere
      if (kind == 0 || kind == 2) candidate.inverse_depth += depth_step * random.Signed();
      if (kind == 1 || kind == 2) {
        // Tilts grow with the slant, for equal angles are larger tangents there.
        const float unit = plane->inverse_depth / focal;
        const float slope2 = (plane->gx * plane->gx + plane->gy * plane->gy) / (unit * unit);
        const float step = set_.slope_step * unit * (1 + slope2);
        candidate.gx += step * random.Signed();
        candidate.gy += step * random.Signed();
      }
      if (kind == 3) {
        candidate.inverse_depth = bounds.farthest + (bounds.nearest - bounds.farthest) * random.Unit();
        candidate.gx = candidate.inverse_depth / focal * 1.5f * random.Signed();
        candidate.gy = candidate.inverse_depth / focal * 1.5f * random.Signed();
      }
      if (!Legal(x, y, candidate, bounds)) continue;
      Accept(candidate, Evaluate(candidate, sources, *cost), plane, cost);
    }
  }

  const SweepInputs& in_;
  const SweepSettings& set_;
  PlaneMap& map_;
  const GreyMask& image_;
  const Pinhole camera_;
  const PatchCostFunction cost_;
  const BilateralTable bilateral_{kColorScale};
  const int count_;
  float px_per_inverse_depth_ = 1;
  std::array<Transfer, kMaxSources> to_source_, from_source_;
  std::array<const GreyMask*, kMaxSources> source_images_{};
  std::int64_t evaluations_ = 0;

  // Of the pixel that is visited.
  RefPatch patch_;
  float x_ = 0, y_ = 0, prior_ = 0, prior_weight_ = 0;
  std::array<Eigen::Vector3f, kMaxSources> base_;
  int candidates_ = 0;
  std::array<PlaneHypothesis, 9> candidate_;
  float matrix_[9][kMaxSources];
};

}  // namespace

PlaneMap::PlaneMap(int w, int h)
    : width(w), height(h), planes(static_cast<std::size_t>(w) * h), cost(planes.size(), kInfinite), sources(planes.size(), 0) {}

Eigen::Vector3d PlaneNormal(const Pinhole& camera, double x, double y, const PlaneHypothesis& plane) {
  const double c = plane.inverse_depth - plane.gx * x - plane.gy * y;
  return -Eigen::Vector3d(camera.fx * plane.gx, camera.fy * plane.gy, camera.cx * plane.gx + camera.cy * plane.gy + c).normalized();
}

bool Visited(const SweepInputs& inputs, int x, int y) {
  const DepthBounds& b = *inputs.bounds;
  const int shift = b.shift - inputs.level;
  const int bx = std::min(x >> shift, b.nearest.width - 1), by = std::min(y >> shift, b.nearest.height - 1);
  return *b.nearest.at(bx, by) > 0 && InMask(*inputs.reference->levels[inputs.level].grey.at(x, y));
}

double PixelsPerInverseDepth(const SweepInputs& inputs) {
  // At the middle of the picture, at the mean of the bounds there.
  const DepthBounds& b = *inputs.bounds;
  double w = 0;
  std::int64_t n = 0;
  for (std::size_t i = 0; i < b.nearest.data.size(); ++i)
    if (b.nearest.data[i] > 0) w += 0.5 * (b.nearest.data[i] + b.farthest.data[i]), ++n;
  if (n == 0 || inputs.sources.empty()) return 1;
  w /= static_cast<double>(n);
  const Pinhole& camera = inputs.reference->camera(inputs.level);
  const Eigen::Vector3f p(static_cast<float>(camera.width * 0.5), static_cast<float>(camera.height * 0.5), 1);
  double sum = 0;
  for (const DenseView* source : inputs.sources) {
    const Transfer t = MakeTransfer(*inputs.reference, *source, inputs.level);
    auto at = [&](double inverse_depth) -> Eigen::Vector2d {
      const Eigen::Vector3d h = (t.a * p).cast<double>() + t.b.cast<double>() * inverse_depth;
      return h.head<2>() / h.z();
    };
    sum += (at(w * 1.01) - at(w * 0.99)).norm() / (0.02 * w);
  }
  return std::max(1e-9, sum / static_cast<double>(inputs.sources.size()));
}

std::int64_t Sweep(const SweepInputs& inputs, const SweepSettings& settings, PlaneMap* map) { return Sweeper(inputs, settings, map).Run(); }

}  // namespace keypose::reconstruct
