#include "reconstruct/stereo/dense.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/cloud/cloud_rows.h"
#include "reconstruct/numerics/cpu_seconds.h"
#include "reconstruct/stereo/frontier_cloud.h"
#include "reconstruct/stereo/fusion.h"
#include "reconstruct/stereo/gap_fill.h"
#include "reconstruct/stereo/hull_fill.h"
#include "views/hull/depth_bounds.h"
#include "views/hull/view_selection.h"
#include "views/hull/visual_hull.h"
#include "views/stereo/patch_match.h"

namespace keypose::reconstruct {
namespace {

std::vector<std::vector<Eigen::Vector3d>> Seeds(const std::vector<PreparedView>& views,
                                                const Scene& scene) {
  std::vector<std::vector<Eigen::Vector3d>> of_scene(scene.views.size()), seeds(views.size());
  for (const SparsePoint& point : scene.points)
    for (const int v : point.views)
      if (v >= 0 && v < std::ssize(of_scene)) of_scene[v].push_back(point.position);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (views[i].scene_index >= 0 && views[i].scene_index < std::ssize(of_scene))
      seeds[i] = of_scene[views[i].scene_index];
  return seeds;
}

void RequireSources(const std::vector<PreparedView>& views, std::vector<std::vector<int>>* sources,
                    DenseResult* result) {
  for (std::size_t i = 0; i < views.size(); ++i)
    if ((*sources)[i].size() < 2) {
      result->views_without_sources.push_back(views[i].name);
      (*sources)[i].clear();
    }
  if (result->views_without_sources.size() == views.size())
    throw InputError(
        "dense: no view has two others that see the same surface from 3 to 65 degrees apart (" +
        NameList(result->views_without_sources) + "); take more photographs, closer together");
}

void Append(const PointCloud& more, PointCloud* cloud) {
  const int before = static_cast<int>(cloud->points.rows()),
            added = static_cast<int>(more.points.rows());
  cloud->points.conservativeResize(before + added, 3);
  cloud->normals.conservativeResize(before + added, 3);
  cloud->colors.conservativeResize(before + added, 3);
  cloud->confidence.conservativeResize(before + added);
  cloud->points.bottomRows(added) = more.points;
  cloud->normals.bottomRows(added) = more.normals;
  cloud->colors.bottomRows(added) = more.colors;
  cloud->confidence.tail(added) = more.confidence;
}

// Depth bounds are as coarse as the grid; this removes points that the masks exclude, accurate to
// the pixel.
int KeepWithinOutlines(const Silhouettes& silhouettes, double limit_px, PointCloud* cloud) {
  std::vector<char> keep(cloud->points.rows(), 1);
  ParallelFor(
      cloud->points.rows(),
      [&](std::int64_t i) { keep[i] = silhouettes.Within(cloud->points.row(i), limit_px); }, 1024);
  return KeepRows(keep, cloud);
}

}  // namespace

void DenseOptions::Describe(OptionVisitor& visit) {
  visit("backend", backend,
        {"patchmatch is Keypose's own on all cores; colmap_cuda is COLMAP's, where a CUDA build is "
         "installed",
         "",
         {},
         {},
         {"patchmatch", "colmap_cuda"}});
  visit("max_size", max_size,
        {"longer side of the pictures that are matched; larger photographs are scaled down", "px",
         64, 20000});
  visit("levels", levels, {"pyramid levels, each of half the size of the one before", "", 1, 6});
  visit("sources", sources, {"views that each view is matched with", "", 2, 16});
  visit("geometric_passes", geometric_passes,
        {"passes with geometric consistency between views, at the finest level", "", 0, 6});
  visit("least_views", least_views, {"views that must agree on a point", "", 2, 10});
  visit("largest_cost", largest_cost,
        {"pixels whose windows match worse than this (0 perfect, 1 unrelated) are dropped", "",
         0.05, 2});
  visit("largest_error", largest_error,
        {"pixels with a larger expected depth error than this, and than the median, are dropped",
         "px of the picture on the surface", 0.05, 100});
  visit("narrow_texture", narrow_texture,
        {"at the finest level windows are half as wide where their contrast is at least this many "
         "times the noise, for sharper detail; 0: always",
         "", 0, 1000});
  visit("window_variance", window_variance,
        {"variance of the matching window along an axis, which averages depths; the bias is "
         "corrected; 0: no correction, which flattens bumps",
         "px2", 0, 40});
  visit("hull_resolution", hull_resolution,
        {"voxels of the visual hull along its longest side", "", 32, 512});
  visit("outline_px", outline_px,
        {"points that lie outside of the masks by more than this are dropped", "px", 0, 100});
  visit("frontier_points", frontier_points,
        {"add frontier points, where the masks' outlines touch the surface, and drop points that "
         "lie above or below them"});
  visit("gap_fill", gap_fill,
        {"add points of smooth surface, at low confidence, over gaps without texture that "
         "confirmed depths surround"});
  visit("hull_fill", hull_fill,
        {"add points of the visual hull, at low confidence, where no view found a depth"});
}

namespace {

/// What the masks say of space.
struct HullOfViews {
  VisualHull hull;
  std::vector<DepthBounds> bounds;  ///< one per view
};

HullOfViews CarveHull(const std::vector<PreparedView>& views, int resolution) {
  VisualHullOptions options;
  options.resolution = resolution;
  options.outside_votes = OutsideVotes(views.size());
  HullOfViews carved{CarveVisualHull(views, options), std::vector<DepthBounds>(views.size())};
  ParallelFor(std::ssize(views),
              [&](std::int64_t i) { carved.bounds[i] = HullDepthBounds(carved.hull, views[i]); });
  return carved;
}

stereo::PatchMatchResult Match(const std::vector<PreparedView>& views, const Scene& scene,
                               const std::vector<std::vector<int>>& sources,
                               const std::vector<DepthBounds>& bounds, const DenseOptions& options,
                               Progress* progress, DenseResult& result) {
  stereo::PatchMatchOptions matching;
  matching.geometric_passes = options.geometric_passes;
  matching.narrow_texture = options.narrow_texture;
  const double cpu_before = CpuSeconds();
  stereo::PatchMatchResult matched =
      stereo::EstimatePlanes(views, sources, bounds, Seeds(views, scene), matching, progress);
  result.matching_cpu_seconds = CpuSeconds() - cpu_before;
  result.evaluations = matched.evaluations;
  return matched;
}

FusionOptions FusionFor(const DenseOptions& options) {
  FusionOptions fusion;
  fusion.least_views = options.least_views;
  fusion.reprojection_px = options.reprojection_px;
  fusion.depth_tolerance = options.depth_tolerance;
  fusion.normal_tolerance_deg = options.normal_tolerance_deg;
  fusion.largest_cost = options.largest_cost;
  fusion.largest_error = options.largest_error;
  fusion.window_variance = options.window_variance;
  return fusion;
}

/// Takes the fused points, drops those that outlines or frontier points contradict, and adds points
/// where stereo found none.
void CompleteCloud(const std::vector<PreparedView>& views,
                   const std::vector<std::vector<int>>& sources, const HullOfViews& carved,
                   const Silhouettes& silhouettes, FusionResult fused, const DenseOptions& options,
                   DenseResult& result) {
  result.cloud = std::move(fused.cloud);
  result.outside_points = KeepWithinOutlines(silhouettes, options.outline_px, &result.cloud);
  const std::vector<FrontierPoint> frontier =
      options.frontier_points ? FindFrontierPoints(carved.hull, silhouettes, views)
                              : std::vector<FrontierPoint>{};
  result.contradicted_points = DropWhatFrontierPointsContradict(frontier, {}, &result.cloud);
  result.stereo_points = static_cast<int>(result.cloud.points.rows());
  if (options.gap_fill) {
    PointCloud bridges =
        FillGaps(views, sources, fused.cells, {.least_views = options.least_views});
    KeepWithinOutlines(silhouettes, options.outline_px, &bridges);
    result.contradicted_points += DropWhatFrontierPointsContradict(frontier, {}, &bridges);
    result.gap_points = static_cast<int>(bridges.points.rows());
    Append(bridges, &result.cloud);
  }
  if (options.hull_fill)
    Append(HullFill(carved.hull, silhouettes, views, carved.bounds, fused.confirmed, result.cloud),
           &result.cloud);
  // Appended after the hull's points, so that hull points near frontier points remain and support
  // the surface where frontier points end.
  result.frontier_points = SizeOf(frontier);
  Append(FrontierCloud(frontier, views), &result.cloud);
}

}  // namespace

DenseResult ReconstructDense(const std::vector<PreparedView>& views, const Scene& scene,
                             const DenseOptions& options, Progress* progress) {
  if (views.size() < 3)
    throw InputError("dense: " + std::to_string(views.size()) +
                     " views have a mask and a pose; stereo needs at least 3");
  DenseResult result;
  ReportProgress(progress, 0.02, "visual hull");
  const HullOfViews carved = CarveHull(views, options.hull_resolution);
  result.hull_volume = carved.hull.Volume();
  std::vector<std::vector<int>> sources =
      SelectSourceViews(views, carved.bounds, scene, options.sources);
  RequireSources(views, &sources, &result);
  stereo::PatchMatchResult matched =
      Match(views, scene, sources, carved.bounds, options, progress, result);
  ReportProgress(progress, 0.9, "fusion");
  FusionResult fused = FuseDepthMaps(views, sources, std::move(matched.maps), FusionFor(options));
  result.completeness = std::move(fused.completeness);
  ReportProgress(progress, 0.94, "outlines");
  const Silhouettes silhouettes(views, OutsideVotes(views.size()));
  result.hull_check = CheckAgainstHull(views, carved.hull, silhouettes);
  CompleteCloud(views, sources, carved, silhouettes, std::move(fused), options, result);
  if (result.cloud.points.rows() == 0)
    throw InputError("dense: no two views agree on any point (" + std::to_string(views.size()) +
                     " views from " + views.front().name + " to " + views.back().name +
                     "); look at the cameras of sfm, and whether the object has texture and the "
                     "photographs are sharp");
  return result;
}

}  // namespace keypose::reconstruct
