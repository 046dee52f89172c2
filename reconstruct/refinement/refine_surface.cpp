#include "reconstruct/refinement/refine_surface.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"
#include "reconstruct/refinement/displacement_solve.h"
#include "reconstruct/refinement/photo_profile.h"
#include "reconstruct/refinement/shading_normals.h"
#include "reconstruct/refinement/surface_outlines.h"
#include "reconstruct/refinement/vertex_views.h"
#include "views/hull/frontier_points.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {
namespace {

using Values = std::vector<float>;

constexpr int kSteps = 8;           // offsets to each side
constexpr double kStep = 0.5;       // pixels of the level, at levels above 0
constexpr double kFineStep = 0.25;  // at level 0
constexpr int kSearches = 4;        // searches and solutions of one set of profiles
constexpr int kRelax = 2;           // rounds of tangential smoothing before each search
constexpr int kSmoothNormals = 2, kMostSmoothNormals = 60;
constexpr int kUnfoldings = 5;
constexpr double kLeastEvidence = 0.02;
constexpr int kHullResolution = 200;  // it only bounds rays
constexpr int kGrain = 1024;

// No record of the data; the room's tests are on rendered balls, its results on the synthetic rings
// and the plush dog (docs/algorithms/refine.md). Sensitivity:
// docs/results/sensitivity.md.
struct ProfileTuning {
  // smaller weights are reduced more than proportionally [of a minimum: cost per squared footprint]
  KEYPOSE_TUNED(float, kFaint, 0.01f);
  // of the cost; a minimum this much below its profile's mean has half of the full agreement
  KEYPOSE_TUNED(float, kContrast, 0.05f);
};

// The minimum of a profile near the vertex's position, and its weight: the curvature of the minimum
// times the square of the agreement.
struct ProfileMinimum {
  float target = 0, weight = 0;
};

ProfileMinimum Search(const float* cost, int count, float step, float at, float window,
                      float pull) {
  const int middle = count / 2;
  int best = -1;
  float least = 1e9f;
  for (int k = 0; k < count; ++k) {
    const float offset = static_cast<float>(k - middle) * step, away = offset - at;
    if (std::abs(away) > window) continue;
    const float value = cost[k] + pull * away * away;
    if (value < least) {
      least = value;
      best = k;
    }
  }
  if (best < 0) return {};
  // The agreement is high for a single distinct minimum, not for one of many.
  float usual = 0;
  for (int k = 0; k < count; ++k) usual += cost[k] / static_cast<float>(count);
  const float contrast = std::max(0.0f, usual - cost[best]),
              agreement =
                  std::max(0.0f, 1 - cost[best]) * contrast / (contrast + ProfileTuning::kContrast);
  // the minimum is out of range: move towards it, with less weight
  if (best == 0 || best == count - 1) {
    const float slope = std::abs(cost[best] - cost[best == 0 ? 1 : count - 2]);
    return {static_cast<float>(best - middle) * step,
            0.5f * slope / (step * step) * agreement * agreement};
  }
  const float before = cost[best - 1], here = cost[best], after = cost[best + 1],
              bend = before - 2 * here + after;
  if (bend <= 1e-6f) return {static_cast<float>(best - middle) * step, 0};
  const float part = std::clamp(0.5f * (before - after) / bend, -0.5f, 0.5f);
  return {(static_cast<float>(best - middle) + part) * step,
          bend / (step * step) * agreement * agreement};
}

class Refiner {
 public:
  Refiner(const Mesh& surface, const std::vector<PreparedView>& views, const RefineOptions& options)
      : views_(views), options_(options), silhouettes_(views, OutsideVotes(views.size())) {
    result_.mesh = surface;
    result_.mesh.normals.resize(0, 3);
    FindFrontier();
    neighbors_ = MakeNeighbors(surface.points, surface.faces);
    border_ = BoundaryVertices(surface.vertex_count(), surface.faces);
  }

  RefineResult Run(Progress* progress) {
    const PointsX3 start = result_.mesh.points;
    const int total = options_.levels * options_.rounds;
    Look(true);
    result_.cost_before = MeanCost();
    for (int level = options_.levels - 1, done = 0; level >= 0; --level)
      for (int round = 0; round < options_.rounds; ++round, ++done) {
        ReportProgress(progress, 0.1 + 0.9 * done / total, "level " + std::to_string(level));
        Round(level, round);
      }
    Look(false);
    result_.cost_after = MeanCost();
    result_.outline_gap_px = OutlineTargets(result_.mesh, silhouettes_, {}, {.violation_weight = 0})
                                 .gap_spread_px;  // of contours
    Values moved(start.rows());
    for (Eigen::Index v = 0; v < start.rows(); ++v)
      moved[v] = static_cast<float>((result_.mesh.points.row(v) - start.row(v)).norm() /
                                    result_.footprint);
    result_.moved_median = QuantileFloor(moved, 0.5);
    result_.moved_95 = QuantileFloor(std::move(moved), 0.95);
    return std::move(result_);
  }

 private:
  void FindFrontier() {
    VisualHullOptions hull;
    hull.resolution = kHullResolution;
    hull.outside_votes = silhouettes_.outside_votes();
    frontier_ = FindFrontierPoints(CarveVisualHull(views_, hull), silhouettes_, views_);
  }

  PointsX3 SmoothNormals() const {
    const PointsX3 own = VertexNormals(result_.mesh.points, result_.mesh.faces);
    Values values(own.size());
    for (Eigen::Index i = 0; i < own.size(); ++i) values[i] = static_cast<float>(own.data()[i]);
    Diffuse(neighbors_, 3, normal_rounds_, std::vector<char>(own.rows(), 1), &values);
    PointsX3 out(own.rows(), 3);
    for (Eigen::Index v = 0; v < own.rows(); ++v) {
      out.row(v) << values[3 * v], values[3 * v + 1], values[3 * v + 2];
      const double length = out.row(v).norm();
      if (length > 0.1)
        out.row(v) /= length;
      else
        out.row(v) = own.row(v);
    }
    return out;
  }

  void Look(bool first) {
    normals_ = SmoothNormals();
    sights_ = AllSights(result_.mesh, normals_, views_);
    chosen_ = ChooseViews(result_.mesh.points, views_, sights_);
    if (!first) return;
    Values footprints;
    for (const VertexViews& v : chosen_)
      if (v.count >= 2) footprints.push_back(v.footprint);
    if (footprints.empty())
      throw InputError(
          "refine: no vertex of the surface lies within the masks of two photographs that it "
          "faces; the surface was made from other "
          "photographs or cameras: run mesh again on these");
    result_.seen = static_cast<double>(footprints.size()) / static_cast<double>(chosen_.size());
    result_.footprint = QuantileFloor(std::move(footprints), 0.5);
  }

  // Mean cost of the surface as it is now, over the compared vertices.
  double MeanCost() const {
    const Profiles here =
        CostProfiles(result_.mesh.points, normals_, chosen_, views_, 0, 0, result_.footprint);
    double sum = 0;
    std::size_t count = 0;
    for (const float cost : here.cost)
      if (cost < 1) {
        sum += cost;
        ++count;
      }
    return count ? sum / static_cast<double>(count) : 1;
  }

  // When a rough surface moves far along its own normals, its creases fold and its bumps swell. So
  // the normals are smoothed first, over a distance that depends on the move. Each round of
  // diffusion adds half a squared edge length to the variance of the smoothing.
  void EvenNormals() {
    result_.outline_gap_before_px = outlines_.gap_spread_px;
    const double reach =
        options_.normal_reach * outlines_.gap_spread_px * result_.footprint / neighbors_.mean_edge;
    normal_rounds_ =
        static_cast<int>(std::clamp<double>(2 * reach * reach, kSmoothNormals, kMostSmoothNormals));
  }

  void Round(int level, int round) {
    Relax();
    outlines_ = OutlineTargets(result_.mesh, silhouettes_, frontier_,
                               {.violation_weight = options_.violations});
    if (round == 0 && level == options_.levels - 1) EvenNormals();
    Look(false);
    const double step = (level == 0 ? kFineStep : kStep) * (1 << level);  // footprints
    Profiles profiles = CostProfiles(result_.mesh.points, normals_, chosen_, views_, level, kSteps,
                                     step * result_.footprint);
    std::vector<char> known(chosen_.size());
    for (std::size_t v = 0; v < known.size(); ++v)
      known[v] = *std::min_element(profiles.Row(v), profiles.Row(v) + profiles.count()) < 1;
    Diffuse(neighbors_, profiles.count(), options_.aggregate, known, &profiles.cost);
    shading_ = {};
    if (level == 0 && options_.shading > 0) {
      shading_ = NormalsFromShading(result_.mesh, normals_, neighbors_, views_, sights_,
                                    options_.shading_smooth);
      result_.shading_error_before = shading_.residual_before;
      result_.shading_error_after = shading_.residual_after;
    }
    Values shift(chosen_.size(), 0.0f);
    Solve(profiles, static_cast<float>(step), &shift);
    Move(shift);
  }

  void Solve(const Profiles& profiles, float step, Values* shift) {
    DisplacementEnergy energy;
    energy.unit = result_.footprint;
    energy.anchor = options_.anchor;
    energy.membrane = options_.membrane;
    energy.bending = options_.bending;
    energy.target.resize(shift->size());
    energy.weight.resize(shift->size());
    energy.slope_normals = shading_.normals;
    energy.slope_weight = shading_.weight;
    for (float& weight : energy.slope_weight) weight *= static_cast<float>(options_.shading);
    for (int search = 0; search < kSearches; ++search) {
      // First the whole range, then around the smooth solution.
      const float window = step * static_cast<float>(kSteps) * (search == 0 ? 1.0f : 0.5f);
      const float pull = (search == 0 ? 0.05f : 0.1f * static_cast<float>(search)) /
                         (step * step * kSteps * kSteps);
      ParallelBlocks(static_cast<std::int64_t>(shift->size()), kGrain,
                     [&](std::int64_t begin, std::int64_t end) {
                       for (std::int64_t v = begin; v < end; ++v) {
                         ProfileMinimum wish = Search(profiles.Row(v), profiles.count(), step,
                                                      (*shift)[v], window, pull);
                         // Shading that moves over smooth clay gives small weights everywhere,
                         // texture gives large ones.
                         wish.weight *= wish.weight / (wish.weight + ProfileTuning::kFaint);
                         const float outline =
                             static_cast<float>(options_.outlines) * outlines_.weight[v];
                         energy.weight[v] = wish.weight + outline;
                         energy.target[v] =
                             static_cast<float>(wish.weight * wish.target +
                                                outline * outlines_.offset[v] / result_.footprint) /
                             std::max(energy.weight[v], 1e-20f);
                       }
                     });
      SolveDisplacement(result_.mesh.points, normals_, neighbors_, energy, shift);
    }
    std::size_t sure = 0;
    for (const float weight : energy.weight) sure += weight > kLeastEvidence;
    result_.evidence = static_cast<double>(sure) / static_cast<double>(shift->size());
    Unfold(&energy, shift);
  }

  // Constraints on faces that would turn over, and on their neighbours, are dropped.
  void Unfold(DisplacementEnergy* energy, Values* shift) {
    HoldInside(shift);
    for (int round = 0; round < kUnfoldings; ++round) {
      std::vector<char> folded = Folded(Moved(*shift));
      const auto count = std::count(folded.begin(), folded.end(), 1);
      if (round == 0) result_.unfolded += static_cast<int>(count);
      if (count == 0) return;
      folded = Grown(folded);
      for (std::size_t v = 0; v < folded.size(); ++v)
        if (folded[v]) energy->weight[v] *= 0.1f;
      if (energy->slope_weight.size() == folded.size())
        for (std::size_t v = 0; v < folded.size(); ++v)
          if (folded[v]) energy->slope_weight[v] *= 0.1f;
      SolveDisplacement(result_.mesh.points, normals_, neighbors_, *energy, shift);
      HoldInside(shift);
    }
    for (int round = 0; round < kUnfoldings; ++round) {
      const std::vector<char> folded = Folded(Moved(*shift));
      for (std::size_t v = 0; v < folded.size(); ++v)
        if (folded[v]) (*shift)[v] = 0;
    }
  }

  std::vector<char> Grown(const std::vector<char>& marked) const {
    std::vector<char> out = marked;
    for (int v = 0; v < neighbors_.vertex_count(); ++v)
      for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e)
        out[v] |= marked[neighbors_.vertex[e]];
    return out;
  }

  void Move(const Values& shift) {
    result_.mesh.points = Moved(shift);
    for (std::size_t v = 0; v < shift.size(); ++v)
      outlines_.offset[v] -= shift[v] * static_cast<float>(result_.footprint);
  }

  // Marching cubes leave slivers, whose normals are unstable. So vertices move along the surface
  // towards the centroid of their neighbours.
  void Relax() {
    for (int round = 0; round < kRelax; ++round) {
      const PointsX3 from = result_.mesh.points, normals = VertexNormals(from, result_.mesh.faces);
      ParallelFor(
          from.rows(),
          [&](std::int64_t v) {
            if (border_[v] || neighbors_.inverse_sum[v] == 0) return;
            Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
            for (int e = neighbors_.begin[v]; e < neighbors_.begin[v + 1]; ++e)
              mean += from.row(neighbors_.vertex[e]);
            const Eigen::RowVector3d way = mean / (neighbors_.begin[v + 1] - neighbors_.begin[v]) -
                                           from.row(v),
                                     normal = normals.row(v);
            result_.mesh.points.row(v) += 0.5 * (way - way.dot(normal) * normal);
          },
          kGrain);
    }
    neighbors_ = MakeNeighbors(result_.mesh.points, result_.mesh.faces);
  }

  PointsX3 Moved(const Values& shift) const {
    PointsX3 out = result_.mesh.points;
    for (Eigen::Index v = 0; v < out.rows(); ++v)
      out.row(v) += shift[v] * result_.footprint * normals_.row(v);
    return out;
  }

  // Vertices of faces that the move turns over.
  std::vector<char> Folded(const PointsX3& moved) const {
    const FacesX3& faces = result_.mesh.faces;
    const PointsX3 before = FaceNormals(result_.mesh.points, faces),
                   after = FaceNormals(moved, faces);
    std::vector<char> folded(moved.rows(), 0);
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      if (before.row(f).dot(after.row(f)) < 0.3 && before.row(f).squaredNorm() > 0)
        for (int c = 0; c < 3; ++c) folded[faces(f, c)] = 1;
    return folded;
  }

  // Limits displacements so that no vertex leaves the masks.
  void HoldInside(Values* shift) {
    std::vector<char> held(shift->size(), 0);
    ParallelFor(
        static_cast<std::int64_t>(shift->size()),
        [&](std::int64_t v) {
          const Eigen::Vector3d x = result_.mesh.points.row(v),
                                way = result_.footprint * normals_.row(v).transpose();
          for (int k = 0; k < 4; ++k) {
            float& d = (*shift)[v];
            if (d <= 0 || silhouettes_.Within(x + d * way, options_.outside_px)) return;
            held[v] = 1;
            d = k < 2 ? 0.5f * d : 0.0f;
          }
        },
        kGrain);
    result_.held_inside = static_cast<int>(std::count(held.begin(), held.end(), 1));
  }

  const std::vector<PreparedView>& views_;
  const RefineOptions& options_;
  Silhouettes silhouettes_;
  Neighbors neighbors_;
  int normal_rounds_ = kSmoothNormals;
  std::vector<char> border_;
  PointsX3 normals_;
  std::vector<VertexViews> chosen_;
  RefineResult result_;
  SurfaceTargets outlines_;
  std::vector<FrontierPoint> frontier_;
  std::vector<std::vector<float>> sights_;
  ShadingNormals shading_;
};

}  // namespace

void RefineOptions::Describe(OptionVisitor& visit) {
  visit("max_size", max_size,
        {"longer side of the pictures that are compared; larger photographs are scaled down", "px",
         64, 20000});
  visit("levels", levels,
        {"pyramid levels, each of half the size of the one before; the coarsest goes first", "", 1,
         6});
  visit("rounds", rounds, {"searches along new normals at each level", "", 1, 10});
  visit(
      "anchor", anchor,
      {"weight that keeps a vertex in place where photographs have little texture", "", 1e-6, 100});
  visit("membrane", membrane, {"weight of equal displacements of neighbours", "", 0, 100});
  visit("bending", bending,
        {"weight against bending, which dominates where photographs have little texture", "", 0,
         100000});
  visit("outlines", outlines,
        {"weight of a view in which a vertex lies on the outline; 1 is the weight of good texture",
         "", 0, 1000});
  visit("violations", violations,
        {"weight of silhouette violations (a mask shows background where the surface is), "
         "relative to `outlines`; 0 ignores them",
         "", 0, 1});
  visit("shading", shading,
        {"weight of normals from shading, which give fine detail; 0 ignores them", "", 0, 1000});
  visit("normal_reach", normal_reach,
        {"normals are smoothed before the surface moves, over this many times its mean distance "
         "to the masks' outlines; 0: no smoothing",
         "gaps", 0, 10});
}

RefineResult RefineSurface(const Mesh& surface, const std::vector<PreparedView>& views,
                           const RefineOptions& options, Progress* progress) {
  RequireUsable(surface, "refine: the surface");
  return Refiner(surface, views, options).Run(progress);
}

}  // namespace keypose::reconstruct
