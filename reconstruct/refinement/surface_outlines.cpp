#include "reconstruct/refinement/surface_outlines.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/tuned.h"
#include "reconstruct/numerics/weighted_median.h"
#include "reconstruct/refinement/outline_constraints.h"

namespace keypose::reconstruct {
namespace {

// Tuned on the plush dog with 34 views and the synthetic rings
// (docs/algorithms/refine.md); of kNeighbourFacing there is no record. Sensitivity:
// docs/results/sensitivity.md.
struct OutlineTuning {
  KEYPOSE_TUNED(double, kNeighbourFacing, 0.7);  // cosine between neighbours' normals
  KEYPOSE_TUNED(double, kLeastSpread, 0.5);      // px; outlines of masks are not more accurate
  // ratio; a view up to this factor worse than the typical view keeps its full weight
  KEYPOSE_TUNED(double, kUsualMisses, 1.5);
};

constexpr int kNeighbors = 48;
constexpr int kRounds = 2;
constexpr int kOutlineGrain = 256;

using Constraint = OutlineConstraint;
using Weighed = std::pair<double, double>;  // value, weight

// Constraints [begin, end) of one vertex, with the median and spread of the constraints around it.
struct Place {
  int begin = 0, end = 0;
  double usual = 0, spread = 0;  // pixels
  struct Near {
    int constraint = 0;
    float weight = 0;
  };
  std::vector<Near> around;
};

// Weights constraints by comparison with those around them. All in pixels, since a constraint is as
// accurate as its mask.
class Consensus {
 public:
  /// @param constraints  sorted by vertex
  Consensus(const std::vector<Constraint>& constraints, const Mesh& mesh, const PointsX3& normals,
            int views, const OutlineTargetOptions& options)
      : constraints_(constraints),
        mesh_(mesh),
        normals_(normals),
        options_(options),
        trust_(views, 1.0) {
    for (int begin = 0, end = 0; begin < std::ssize(constraints); begin = end) {
      while (end < std::ssize(constraints) && constraints[end].vertex == constraints[begin].vertex)
        ++end;
      places_.push_back({begin, end, 0, 0, {}});
    }
    FindNeighbors();
    for (int round = 0; round < kRounds; ++round) {
      ParallelFor(
          std::ssize(places_), [&](std::int64_t i) { WhatIsUsual(&places_[i]); }, kOutlineGrain);
      TrustViews();
    }
  }

  const std::vector<Place>& places() const { return places_; }

  // Inlier weight of a constraint, in [0, 1]: Tukey's biweight of its residual.
  double InlierWeight(const Place& place, const Constraint& constraint) const {
    const double miss = Miss(place, constraint) /
                        (options_.errors * std::max(place.spread, OutlineTuning::kLeastSpread));
    const double rest = std::max(0.0, 1 - miss * miss);
    // Constraints from fur scatter, so each has less weight.
    const double scatter = std::max(place.spread / OutlineTuning::kLeastSpread, 1.0);
    return trust_[constraint.view] * rest * rest / (scatter * scatter);
  }

 private:
  static double Pixels(const Constraint& constraint) {
    return constraint.offset / constraint.footprint;
  }
  static double Miss(const Place& place, const Constraint& constraint) {
    return std::abs(Pixels(constraint) - place.usual);
  }

  void FindNeighbors() {
    PointsX3 points(constraints_.size(), 3);
    for (std::size_t i = 0; i < constraints_.size(); ++i)
      points.row(static_cast<int>(i)) = mesh_.points.row(constraints_[i].vertex);
    const KdTree tree(points);
    ParallelFor(
        std::ssize(places_),
        [&](std::int64_t i) {
          Place& place = places_[i];
          const Constraint& first = constraints_[place.begin];
          const Eigen::Vector3d normal = normals_.row(first.vertex);
          const double reach = options_.smoothing_px * first.footprint;
          for (const KdTree::Neighbor& near : tree.Nearest(points.row(place.begin), kNeighbors)) {
            const double facing = normal.dot(normals_.row(constraints_[near.index].vertex));
            const double distance = near.squared_distance / (reach * reach);
            if (facing < OutlineTuning::kNeighbourFacing || distance > 9) continue;
            place.around.push_back(
                {near.index, static_cast<float>(facing * facing * std::exp(-0.5 * distance))});
          }
        },
        kOutlineGrain);
  }

  void WhatIsUsual(Place* place) const {
    // A view with a long outline here gets little more weight than one with a short outline.
    std::vector<double> of_view(trust_.size(), 1e-12);
    for (const Place::Near& near : place->around)
      of_view[constraints_[near.constraint].view] +=
          near.weight * constraints_[near.constraint].weight;
    std::vector<Weighed> values;
    for (const Place::Near& near : place->around) {
      const Constraint& constraint = constraints_[near.constraint];
      values.push_back(
          {Pixels(constraint), trust_[constraint.view] * near.weight * constraint.weight /
                                   std::sqrt(of_view[constraint.view])});
    }
    place->usual = WeightedMedian(&values);
    for (Weighed& w : values) w.first = std::abs(w.first - place->usual);
    place->spread = 1.48 * WeightedMedian(&values);
  }

  // The weight of a view falls with the square of its residual relative to other views'.
  void TrustViews() {
    std::vector<std::vector<Weighed>> misses(trust_.size());
    for (const Place& place : places_)
      for (int i = place.begin; i < place.end; ++i)
        misses[constraints_[i].view].push_back(
            {Miss(place, constraints_[i]), constraints_[i].weight});
    std::vector<Weighed> typical;
    std::vector<double> miss(trust_.size(), 0);
    for (std::size_t v = 0; v < trust_.size(); ++v) {
      miss[v] = std::max(WeightedMedian(&misses[v]), 0.1 * OutlineTuning::kLeastSpread);
      if (!misses[v].empty()) typical.push_back({miss[v], 1});
    }
    const double limit = OutlineTuning::kUsualMisses *
                         std::max(WeightedMedian(&typical), 0.1 * OutlineTuning::kLeastSpread);
    for (std::size_t v = 0; v < trust_.size(); ++v)
      trust_[v] = std::min(1.0, std::pow(limit / miss[v], 2));
  }

  const std::vector<Constraint>& constraints_;
  const Mesh& mesh_;
  const PointsX3& normals_;
  const OutlineTargetOptions& options_;
  std::vector<double> trust_;  // weight of each view
  std::vector<Place> places_;
};

void Measure(const std::vector<Constraint>& contour, SurfaceTargets* targets) {
  double total = 0;
  for (const Constraint& constraint : contour) {
    targets->gap_px += constraint.weight * constraint.offset / constraint.footprint;
    targets->gap_spread_px +=
        constraint.weight * std::abs(constraint.offset / constraint.footprint);
    total += constraint.weight;
  }
  if (total > 0) {
    targets->gap_px /= total;
    targets->gap_spread_px /= total;
  }
}

// Each kind is compared with its own kind only: a dent has few constraints, and would be an outlier
// among the many contour terms around it.
class OutlineSum {
 public:
  OutlineSum(const Mesh& mesh, const PointsX3& normals, int views,
             const OutlineTargetOptions& options)
      : mesh_(mesh),
        normals_(normals),
        views_(views),
        options_(options),
        offset_(mesh.vertex_count(), 0),
        weight_(mesh.vertex_count(), 0) {}

  void Add(const std::vector<Constraint>& constraints) {
    if (constraints.empty()) return;
    const Consensus consensus(constraints, mesh_, normals_, views_, options_);
    for (const Place& place : consensus.places())
      for (int i = place.begin; i < place.end; ++i) {
        const double weight = constraints[i].weight * consensus.InlierWeight(place, constraints[i]);
        offset_[constraints[i].vertex] += weight * constraints[i].offset;
        weight_[constraints[i].vertex] += weight;
      }
  }
  void Get(SurfaceTargets* targets) const {
    for (std::size_t v = 0; v < weight_.size(); ++v) {
      if (weight_[v] < 1e-3) continue;
      targets->offset[v] = static_cast<float>(offset_[v] / weight_[v]);
      targets->weight[v] = static_cast<float>(weight_[v]);
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

SurfaceTargets OutlineTargets(const Mesh& mesh, const Silhouettes& silhouettes,
                              const std::vector<FrontierPoint>& frontier,
                              const OutlineTargetOptions& options) {
  SurfaceTargets targets;
  targets.offset.assign(mesh.vertex_count(), 0);
  targets.weight.assign(mesh.vertex_count(), 0);
  if (mesh.vertex_count() == 0) return targets;
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const OutlineConstraints constraints = FindOutlineConstraints(
      mesh, normals, silhouettes, frontier, options.violation_weight, options.reach_px);
  Measure(constraints.contour, &targets);
  OutlineSum sum(mesh, normals, silhouettes.views(), options);
  for (const std::vector<Constraint>* kind :
       {&constraints.contour, &constraints.frontier, &constraints.violations})
    sum.Add(*kind);
  sum.Get(&targets);
  return targets;
}

}  // namespace keypose::reconstruct
