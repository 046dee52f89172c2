#include "reconstruct/refine_outlines.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "reconstruct/refine_claims.h"
#include "reconstruct/weighted_median.h"

namespace keypose::reconstruct {
namespace {

constexpr double kNeighbourFacing = 0.7;  // cosine between neighbours' normals
constexpr double kLeastSpread = 0.5;  // pixels: outlines of masks are no finer
constexpr int kNeighbors = 48;
constexpr int kRounds = 2;
constexpr double kUsualMisses = 1.5;  // a view that misses by up to this many times what is typical is trusted fully
constexpr int kOutlineGrain = 256;

using Claim = OutlineClaim;
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
  Court(const std::vector<Claim>& claims, const Mesh& mesh, const PointsX3& normals, int views, const OutlineTargetOptions& options)
      : claims_(claims), mesh_(mesh), normals_(normals), options_(options), trust_(views, 1.0) {
    for (int begin = 0, end = 0; begin < static_cast<int>(claims.size()); begin = end) {
      while (end < static_cast<int>(claims.size()) && claims[end].vertex == claims[begin].vertex) ++end;
      places_.push_back({begin, end, 0, 0, {}});
    }
    FindNeighbors();
    for (int round = 0; round < kRounds; ++round) {
      ParallelFor(
          static_cast<std::int64_t>(places_.size()), [&](std::int64_t i) { WhatIsUsual(&places_[i]); }, kOutlineGrain);
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
    for (std::size_t i = 0; i < claims_.size(); ++i) points.row(static_cast<int>(i)) = mesh_.points.row(claims_[i].vertex);
    const KdTree tree(points);
    ParallelFor(
        static_cast<std::int64_t>(places_.size()),
        [&](std::int64_t i) {
          Place& place = places_[i];
          const Claim& first = claims_[place.begin];
          const Eigen::Vector3d normal = normals_.row(first.vertex);
          const double reach = options_.smoothing_px * first.footprint;
          for (const KdTree::Neighbor& near : tree.Nearest(points.row(place.begin), kNeighbors)) {
            const double facing = normal.dot(normals_.row(claims_[near.index].vertex));
            const double distance = near.squared_distance / (reach * reach);
            if (facing < kNeighbourFacing || distance > 9) continue;
            place.around.push_back({near.index, static_cast<float>(facing * facing * std::exp(-0.5 * distance))});
          }
        },
        kOutlineGrain);
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
  const Mesh& mesh_;
  const PointsX3& normals_;
  const OutlineTargetOptions& options_;
  std::vector<double> trust_;  // of each view
  std::vector<Place> places_;
};

void Measure(const std::vector<Claim>& folds, SurfaceTargets* targets) {
  double total = 0;
  for (const Claim& claim : folds) {
    targets->gap_px += claim.weight * claim.offset / claim.footprint;
    targets->gap_spread_px += claim.weight * std::abs(claim.offset / claim.footprint);
    total += claim.weight;
  }
  if (total > 0) targets->gap_px /= total, targets->gap_spread_px /= total;
}

// Claims are judged by others of their kind: a dent makes few, among many folds round it that miss nothing.
class OutlineSum {
 public:
  OutlineSum(const Mesh& mesh, const PointsX3& normals, int views, const OutlineTargetOptions& options)
      : mesh_(mesh),
        normals_(normals),
        views_(views),
        options_(options),
        offset_(mesh.vertex_count(), 0),
        weight_(mesh.vertex_count(), 0) {}

  void Add(const std::vector<Claim>& claims) {
    if (claims.empty()) return;
    const Court court(claims, mesh_, normals_, views_, options_);
    for (const Place& place : court.places())
      for (int i = place.begin; i < place.end; ++i) {
        const double heard = claims[i].weight * court.Heard(place, claims[i]);
        offset_[claims[i].vertex] += heard * claims[i].offset, weight_[claims[i].vertex] += heard;
      }
  }
  void Get(SurfaceTargets* targets) const {
    for (std::size_t v = 0; v < weight_.size(); ++v) {
      if (weight_[v] < 1e-3) continue;
      targets->offset[v] = static_cast<float>(offset_[v] / weight_[v]), targets->weight[v] = static_cast<float>(weight_[v]);
    }
  }

 private:
  const Mesh& mesh_;
  const PointsX3& normals_;
  int views_;
  const OutlineTargetOptions& options_;
  std::vector<double> offset_, weight_;
};

}  // namespace

SurfaceTargets OutlineTargets(const Mesh& mesh, const Silhouettes& silhouettes, const std::vector<RimPoint>& rims,
                              const OutlineTargetOptions& options) {
  SurfaceTargets targets;
  targets.offset.assign(mesh.vertex_count(), 0), targets.weight.assign(mesh.vertex_count(), 0);
  if (mesh.vertex_count() == 0) return targets;
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const OutlineClaims claims = FindOutlineClaims(mesh, normals, silhouettes, rims, options.cut_weight, options.reach_px);
  Measure(claims.folds, &targets);
  OutlineSum sum(mesh, normals, silhouettes.views(), options);
  for (const std::vector<Claim>* kind : {&claims.folds, &claims.rims, &claims.cuts}) sum.Add(*kind);
  sum.Get(&targets);
  return targets;
}

}  // namespace keypose::reconstruct
