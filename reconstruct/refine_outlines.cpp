#include "reconstruct/refine_outlines.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/geometry.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "reconstruct/weighted_median.h"

namespace keypose::reconstruct {
namespace {

constexpr int kFine = 2;              // cells of a view's picture a pixel and axis
constexpr int kMargin = 24;           // pixels round the mask's crop: the surface may stand out
constexpr double kBeyond = 0.75;      // pixels beyond an edge where nothing of the surface may lie
constexpr double kOutermost = 0.2;    // pixels that a fold may lie inside of its neighbours on the outline
constexpr double kLeastFacing = 0.7;  // cosine between the surface's normal and the outline's plane
constexpr double kFullLength = 0.5;   // pixels of outline that make a whole claim
constexpr double kHullSlack = 1;      // pixels that a claim may leave the hull
constexpr double kLeastSpread = 0.5;  // pixels: outlines of masks are no finer
constexpr int kNeighbors = 48;
constexpr int kRounds = 2;
constexpr double kUsualMisses = 1.5;  // a view that misses by up to this many times what is typical is trusted fully
constexpr int kGrain = 256;

// Two faces and the edge between them.
struct Fold {
  int a = 0, b = 0;  // vertices
  int left = 0, right = 0;
};

std::vector<Fold> Folds(const FacesX3& faces) {
  struct Side {
    int low, high, face;
  };
  std::vector<Side> sides;
  sides.reserve(3 * static_cast<std::size_t>(faces.rows()));
  for (int f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int i = faces(f, k), j = faces(f, (k + 1) % 3);
      sides.push_back({std::min(i, j), std::max(i, j), f});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return x.low != y.low ? x.low < y.low : x.high != y.high ? x.high < y.high : x.face < y.face;
  });
  std::vector<Fold> folds;
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high) ++end;
    if (end == begin + 2) folds.push_back({sides[begin].low, sides[begin].high, sides[begin].face, sides[begin + 1].face});
  }
  return folds;
}

// Which cells of a view's picture the surface covers.
class Picture {
 public:
  Picture(int width, int height)
      : width_(kFine * (width + 2 * kMargin)), height_(kFine * (height + 2 * kMargin)), covered_(std::size_t(width_) * height_, 0) {}

  void Fill(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const std::array<Eigen::Vector2d, 3> p = {Cell(a), Cell(b), Cell(c)};
    const double top = std::min({p[0].y(), p[1].y(), p[2].y()}), bottom = std::max({p[0].y(), p[1].y(), p[2].y()});
    if (!(bottom > 0 && top < height_)) return;
    const int first = std::max(0, static_cast<int>(std::floor(top))), last = std::min(height_ - 1, static_cast<int>(std::floor(bottom)));
    for (int y = first; y <= last; ++y) {
      const double middle = y + 0.5;
      double left = 1e30, right = -1e30;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector2d &u = p[k], &v = p[(k + 1) % 3];
        if ((u.y() <= middle) == (v.y() <= middle)) continue;
        const double x = u.x() + (middle - u.y()) / (v.y() - u.y()) * (v.x() - u.x());
        left = std::min(left, x), right = std::max(right, x);
      }
      if (!(right > 0 && left < width_)) continue;
      const int begin = static_cast<int>(std::max(0.0, std::ceil(left - 0.5)));
      const int end = static_cast<int>(std::min<double>(width_, std::ceil(right - 0.5)));
      if (begin < end) std::fill(covered_.begin() + Index(begin, y), covered_.begin() + Index(end, y), std::uint8_t{1});
    }
  }
  bool Covered(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d cell = Cell(pixel);
    if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < width_ && cell.y() < height_)) return false;
    return covered_[Index(static_cast<int>(cell.x()), static_cast<int>(cell.y()))] != 0;
  }

 private:
  static Eigen::Vector2d Cell(const Eigen::Vector2d& pixel) { return kFine * (pixel.array() + 0.5 + kMargin); }
  std::ptrdiff_t Index(int x, int y) const { return static_cast<std::ptrdiff_t>(y) * width_ + x; }
  int width_, height_;
  std::vector<std::uint8_t> covered_;
};

// What one view says of one vertex.
struct Claim {
  int vertex = 0, view = 0;
  double offset = 0;     // world units
  double weight = 0;     // in (0, 1]
  double footprint = 0;  // world length of a pixel
};

// A place on a fold that may be on the outline.
struct Sample {
  int a = 0, b = 0;
  double t = 0, length = 0;  // share of the edge, pixels that it stands for
  double offset = 0, footprint = 0;
  double distance = 0;  // outside of the mask, pixels
  std::size_t bin = 0;  // pixel of the mask's outline
};

struct Surface {
  const Mesh& mesh;
  PointsX3 normals, face_normals;
  std::vector<Fold> folds;
};

class Outline {
 public:
  Outline(const Surface& surface, const Silhouettes& silhouettes, int view, double reach_px)
      : surface_(surface),
        silhouettes_(silhouettes),
        field_(silhouettes.field(view)),
        view_(view),
        reach_px_(reach_px),
        picture_(field_.width, field_.height) {}

  std::vector<Claim> Claims() {
    Project();
    for (const Fold& fold : surface_.folds)
      if (front_[fold.left] != front_[fold.right] && ahead_[fold.a] && ahead_[fold.b]) Walk(fold);
    KeepOutermost();
    return Merged();
  }

 private:
  void Project() {
    const Mesh& mesh = surface_.mesh;
    const Eigen::Vector3d center = -(field_.from_world.leftCols<3>().inverse() * field_.from_world.col(3));
    pixels_.resize(mesh.vertex_count()), ahead_.resize(mesh.vertex_count()), front_.resize(mesh.face_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector3d h = field_.from_world * Eigen::Vector3d(mesh.points.row(v)).homogeneous();
      ahead_[v] = h.z() > 0;
      pixels_[v] = h.head<2>() / (ahead_[v] ? h.z() : 1.0);
    }
    for (int f = 0; f < mesh.face_count(); ++f) {
      const int a = mesh.faces(f, 0), b = mesh.faces(f, 1), c = mesh.faces(f, 2);
      front_[f] = (center - Eigen::Vector3d(mesh.points.row(a))).dot(surface_.face_normals.row(f)) > 0;
      if (ahead_[a] && ahead_[b] && ahead_[c] && !Deep(a, b, c)) picture_.Fill(pixels_[a], pixels_[b], pixels_[c]);
    }
  }

  // Whether all of a face lies deeper in the mask than outlines are asked for: most faces do, and need not be drawn.
  bool Deep(int a, int b, int c) const {
    const Eigen::Vector2d& p = pixels_[a];
    if (!(p.x() >= 0 && p.y() >= 0 && p.x() <= field_.width - 1 && p.y() <= field_.height - 1)) return false;
    const double depth = -field_.At(static_cast<int>(p.x() + 0.5), static_cast<int>(p.y() + 0.5)) - reach_px_ - 2;
    return depth > 0 && depth * depth > std::max((pixels_[b] - p).squaredNorm(), (pixels_[c] - p).squaredNorm());
  }

  void Walk(const Fold& fold) {
    const double length = (pixels_[fold.b] - pixels_[fold.a]).norm();
    const int steps = std::clamp(static_cast<int>(std::ceil(length)), 1, 64);
    for (int k = 0; k < steps; ++k) Ask(fold, (k + 0.5) / steps, std::max(length, 0.1) / steps);
  }

  // At the share t of an edge, which stands for `length` pixels of outline.
  void Ask(const Fold& fold, double t, double length) {
    const PointsX3 &points = surface_.mesh.points, &normals = surface_.normals;
    const Eigen::Vector3d x = (1 - t) * points.row(fold.a) + t * points.row(fold.b);
    const Eigen::Vector3d normal = ((1 - t) * normals.row(fold.a) + t * normals.row(fold.b)).normalized();
    const Silhouettes::Sighting sighting = silhouettes_.See(view_, x);
    if (!sighting.seen || std::abs(sighting.distance) > reach_px_) return;
    const Eigen::Vector3d h = field_.from_world * x.homogeneous(), step = field_.from_world.leftCols<3>() * normal;
    const Eigen::Vector2d pixel = h.head<2>() / h.z();
    if (AtPhotographsEnd(pixel)) return;
    const Eigen::Vector2d away = step.head<2>() - pixel * step.z();
    if (picture_.Covered(pixel + kBeyond * away.normalized())) return;
    const double facing = silhouettes_.RimNormal(view_, x).dot(normal);
    if (facing < kLeastFacing) return;
    const double offset = -sighting.distance * sighting.footprint / facing;
    if (offset > 0 && !silhouettes_.Within(x + offset * normal, kHullSlack)) return;
    const Eigen::Vector2d foot = pixel - sighting.distance * away.normalized();
    samples_.push_back({fold.a, fold.b, t, length, offset, sighting.footprint, sighting.distance, Bin(foot)});
  }

  std::size_t Bin(const Eigen::Vector2d& foot) const {
    const auto cell = [](double at, int size) { return std::clamp<std::ptrdiff_t>(std::lround(at) + kMargin, 1, size + 2 * kMargin - 2); };
    return static_cast<std::size_t>(cell(foot.y(), field_.height) * (field_.width + 2 * kMargin) + cell(foot.x(), field_.width));
  }

  // A rough surface has many folds near its outline. Those that others hide from the outline by a fraction of a pixel say nothing: they
  // would be pulled out.
  void KeepOutermost() {
    const std::ptrdiff_t row = field_.width + 2 * kMargin;
    std::vector<float> outermost(static_cast<std::size_t>(row * (field_.height + 2 * kMargin)), -1e9f);
    for (const Sample& sample : samples_) outermost[sample.bin] = std::max(outermost[sample.bin], static_cast<float>(sample.distance));
    for (const Sample& sample : samples_) {
      float most = -1e9f;
      for (const std::ptrdiff_t y : {-row, std::ptrdiff_t{0}, row})
        for (const std::ptrdiff_t x : {-1, 0, 1}) most = std::max(most, outermost[sample.bin + static_cast<std::size_t>(x + y)]);
      if (sample.distance < most - kOutermost) continue;
      claims_.push_back({sample.a, view_, sample.offset, (1 - sample.t) * sample.length, sample.footprint});
      claims_.push_back({sample.b, view_, sample.offset, sample.t * sample.length, sample.footprint});
    }
  }

  bool AtPhotographsEnd(const Eigen::Vector2d& pixel) const {
    constexpr double kNear = 2;
    return (field_.edges[0] && pixel.x() < kNear) || (field_.edges[1] && pixel.x() > field_.width - 1 - kNear) ||
           (field_.edges[2] && pixel.y() < kNear) || (field_.edges[3] && pixel.y() > field_.height - 1 - kNear);
  }

  std::vector<Claim> Merged() {
    std::stable_sort(claims_.begin(), claims_.end(), [](const Claim& a, const Claim& b) { return a.vertex < b.vertex; });
    std::vector<Claim> merged;
    for (std::size_t begin = 0, end = 0; begin < claims_.size(); begin = end) {
      Claim sum{claims_[begin].vertex, view_, 0, 0, claims_[begin].footprint};
      for (; end < claims_.size() && claims_[end].vertex == sum.vertex; ++end)
        sum.offset += claims_[end].weight * claims_[end].offset, sum.weight += claims_[end].weight;
      sum.offset /= sum.weight;
      sum.weight = std::min(1.0, sum.weight / kFullLength);
      merged.push_back(sum);
    }
    return merged;
  }

  const Surface& surface_;
  const Silhouettes& silhouettes_;
  const MaskField& field_;
  int view_;
  double reach_px_;
  Picture picture_;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<char> ahead_, front_;
  std::vector<Sample> samples_;
  std::vector<Claim> claims_;
};

using Weighed = std::pair<double, double>;  // value, weight

// Claims [begin, end) of one vertex, and what is usual around it.
struct Place {
  int begin = 0, end = 0;
  double usual = 0, spread = 0;  // pixels
  struct Near {
    int claim = 0;
    float weight = 0;
  };
  std::vector<Near> around;
};

// Judges claims by those around them. All in pixels, since a claim is as good as its mask.
class Court {
 public:
  /// @param claims  sorted by vertex
  Court(const std::vector<Claim>& claims, const Surface& surface, int views, const OutlineTargetOptions& options)
      : claims_(claims), surface_(surface), options_(options), trust_(views, 1.0) {
    for (int begin = 0, end = 0; begin < static_cast<int>(claims.size()); begin = end) {
      while (end < static_cast<int>(claims.size()) && claims[end].vertex == claims[begin].vertex) ++end;
      places_.push_back({begin, end, 0, 0, {}});
    }
    FindNeighbors();
    for (int round = 0; round < kRounds; ++round) {
      ParallelFor(
          static_cast<std::int64_t>(places_.size()), [&](std::int64_t i) { WhatIsUsual(&places_[i]); }, kGrain);
      TrustViews();
    }
  }

  const std::vector<Place>& places() const { return places_; }

  // How much of a claim is heard, in [0, 1]: Tukey's biweight of its miss.
  double Heard(const Place& place, const Claim& claim) const {
    const double miss = Miss(place, claim) / (options_.errors * std::max(place.spread, kLeastSpread));
    const double rest = std::max(0.0, 1 - miss * miss);
    // Fur makes claims that scatter: each says less.
    const double scatter = std::max(place.spread / kLeastSpread, 1.0);
    return trust_[claim.view] * rest * rest / (scatter * scatter);
  }

 private:
  static double Pixels(const Claim& claim) { return claim.offset / claim.footprint; }
  static double Miss(const Place& place, const Claim& claim) { return std::abs(Pixels(claim) - place.usual); }

  void FindNeighbors() {
    PointsX3 points(claims_.size(), 3);
    for (std::size_t i = 0; i < claims_.size(); ++i) points.row(static_cast<int>(i)) = surface_.mesh.points.row(claims_[i].vertex);
    const KdTree tree(points);
    ParallelFor(
        static_cast<std::int64_t>(places_.size()),
        [&](std::int64_t i) {
          Place& place = places_[i];
          const Claim& first = claims_[place.begin];
          const Eigen::Vector3d normal = surface_.normals.row(first.vertex);
          const double reach = options_.smoothing_px * first.footprint;
          for (const KdTree::Neighbor& near : tree.Nearest(points.row(place.begin), kNeighbors)) {
            const double facing = normal.dot(surface_.normals.row(claims_[near.index].vertex));
            const double distance = near.squared_distance / (reach * reach);
            if (facing < kLeastFacing || distance > 9) continue;
            place.around.push_back({near.index, static_cast<float>(facing * facing * std::exp(-0.5 * distance))});
          }
        },
        kGrain);
  }

  void WhatIsUsual(Place* place) const {
    // A view that sees much outline here has little more say than one that sees little.
    std::vector<double> of_view(trust_.size(), 1e-12);
    for (const Place::Near& near : place->around) of_view[claims_[near.claim].view] += near.weight * claims_[near.claim].weight;
    std::vector<Weighed> values;
    for (const Place::Near& near : place->around) {
      const Claim& claim = claims_[near.claim];
      values.push_back({Pixels(claim), trust_[claim.view] * near.weight * claim.weight / std::sqrt(of_view[claim.view])});
    }
    place->usual = WeightedMedian(&values);
    for (Weighed& w : values) w.first = std::abs(w.first - place->usual);
    place->spread = 1.48 * WeightedMedian(&values);
  }

  // By the square of how much more than other views a view contradicts.
  void TrustViews() {
    std::vector<std::vector<Weighed>> misses(trust_.size());
    for (const Place& place : places_)
      for (int i = place.begin; i < place.end; ++i) misses[claims_[i].view].push_back({Miss(place, claims_[i]), claims_[i].weight});
    std::vector<Weighed> typical;
    std::vector<double> miss(trust_.size(), 0);
    for (std::size_t v = 0; v < trust_.size(); ++v) {
      miss[v] = std::max(WeightedMedian(&misses[v]), 0.1 * kLeastSpread);
      if (!misses[v].empty()) typical.push_back({miss[v], 1});
    }
    const double limit = kUsualMisses * std::max(WeightedMedian(&typical), 0.1 * kLeastSpread);
    for (std::size_t v = 0; v < trust_.size(); ++v) trust_[v] = std::min(1.0, std::pow(limit / miss[v], 2));
  }

  const std::vector<Claim>& claims_;
  const Surface& surface_;
  const OutlineTargetOptions& options_;
  std::vector<double> trust_;  // of each view
  std::vector<Place> places_;
};

std::vector<Claim> AllClaims(const Surface& surface, const Silhouettes& silhouettes, double reach_px) {
  std::vector<std::vector<Claim>> of_view(silhouettes.views());
  ParallelFor(silhouettes.views(),
              [&](std::int64_t i) { of_view[i] = Outline(surface, silhouettes, static_cast<int>(i), reach_px).Claims(); });
  std::vector<Claim> all;
  for (const std::vector<Claim>& claims : of_view) all.insert(all.end(), claims.begin(), claims.end());
  std::stable_sort(all.begin(), all.end(), [](const Claim& a, const Claim& b) { return a.vertex < b.vertex; });
  return all;
}

void Measure(const std::vector<Claim>& claims, SurfaceTargets* targets) {
  double total = 0;
  for (const Claim& claim : claims) {
    targets->gap_px += claim.weight * claim.offset / claim.footprint;
    targets->gap_spread_px += claim.weight * std::abs(claim.offset / claim.footprint);
    total += claim.weight;
  }
  if (total > 0) targets->gap_px /= total, targets->gap_spread_px /= total;
}

}  // namespace

SurfaceTargets OutlineTargets(const Mesh& mesh, const Silhouettes& silhouettes, const OutlineTargetOptions& options) {
  SurfaceTargets targets;
  targets.offset.assign(mesh.vertex_count(), 0), targets.weight.assign(mesh.vertex_count(), 0);
  const Surface surface{mesh, VertexNormals(mesh.points, mesh.faces), FaceNormals(mesh.points, mesh.faces), Folds(mesh.faces)};
  const std::vector<Claim> claims = AllClaims(surface, silhouettes, options.reach_px);
  if (claims.empty()) return targets;
  Measure(claims, &targets);
  const Court court(claims, surface, silhouettes.views(), options);
  for (const Place& place : court.places()) {
    double sum = 0, weight = 0;
    for (int i = place.begin; i < place.end; ++i) {
      const double heard = claims[i].weight * court.Heard(place, claims[i]);
      sum += heard * claims[i].offset, weight += heard;
    }
    if (weight < 1e-3) continue;
    targets.offset[claims[place.begin].vertex] = static_cast<float>(sum / weight);
    targets.weight[claims[place.begin].vertex] = static_cast<float>(weight);
  }
  return targets;
}

}  // namespace keypose::reconstruct
