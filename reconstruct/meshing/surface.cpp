#include "reconstruct/meshing/surface.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

constexpr int kShallowest = 4;

double CellSize(const PointsX3& points, int depth) {
  const Eigen::RowVector3d extent = points.colwise().maxCoeff() - points.colwise().minCoeff();
  return kPoissonCubeScale * extent.maxCoeff() / std::pow(2.0, depth);
}

// The largest extent without the outermost hundredth on each side, so that a single outlier does
// not affect the fineness of the mesh.
double BulkExtent(const PointsX3& points) {
  double extent = 0;
  for (int c = 0; c < 3; ++c) {
    const auto [low, high] = TrimmedRange(Eigen::VectorXd(points.col(c)), 0.01);
    extent = std::max(extent, high - low);
  }
  return extent;
}

// Poisson's surface is oriented by the normals; a surface oriented against its points would make
// every later step work inside out.
void FaceAlongNormals(Mesh& mesh, const PointCloud& cloud) {
  const KdTree tree(cloud.points);
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const int stride = std::max(1, mesh.vertex_count() / 20000);
  int balance = 0;
  for (int v = 0; v < mesh.vertex_count(); v += stride) {
    const auto near = tree.Nearest(mesh.points.row(v).transpose());
    balance += cloud.normals.row(near.index).dot(normals.row(v)) > 0 ? 1 : -1;
  }
  if (balance < 0) mesh.faces.col(1).swap(mesh.faces.col(2));
}

Mesh Fit(const FilteredPoints& used, const PoissonOptions& options) {
  Mesh surface = ScreenedPoisson(used.cloud.points, used.cloud.normals, used.weights, options);
  FaceAlongNormals(surface, used.cloud);
  return surface;
}

int ViewCount(const std::vector<SightLine>& lines) {
  std::set<int> views;
  for (const SightLine& line : lines) views.insert(line.view);
  return SizeOf(views);
}

}  // namespace

void MeshOptions::Describe(OptionVisitor& visit) {
  visit("depth", depth,
        {"octree levels; 0 chooses them from the distance between points", "levels", 0, 12, {}});
  visit("max_depth", max_depth,
        {"highest number of octree levels that depth 0 chooses", "levels", kShallowest, 12, {}});
  visit("merge", merge,
        {"points closer together than this many of the finest octree cells are merged; 0 keeps all",
         "cells",
         0,
         4,
         {}});
  visit("samples_per_node", poisson.samples_per_node,
        {"least number of points in a leaf: 1 to 5 for clean clouds, 10 to 20 for noisy ones",
         "points",
         1,
         50,
         {}});
  visit("neighbors", filter.neighbors,
        {"neighbours from which the local density is measured", "points", 4, 100, {}});
  visit("min_confidence", filter.min_confidence,
        {"points of lower confidence are not used", "", 0, 1, {}});
  visit("thin_unsure", filter.thin_unsure,
        {"keep only a share of the points that are less confident than their neighbours"});
  visit("trim", trim.trim,
        {"surface farther from all points than this many point distances is cut away; 0 keeps all",
         "spacings",
         0,
         1000,
         {}});
  visit(
      "keep_area", trim.keep_area,
      {"a patch without data stays when it is at most this share of the whole area", "", 0, 1, {}});
  visit("min_component", trim.min_component,
        {"parts with fewer faces than this share of the largest part are removed", "", 0, 1, {}});
}

int DepthForSampling(double diagonal, double spacing, int max_depth) {
  const double levels = std::ceil(std::log2(diagonal / (2 * spacing)));
  return static_cast<int>(std::clamp(levels, static_cast<double>(std::min(kShallowest, max_depth)),
                                     static_cast<double>(max_depth)));
}

SurfaceResult ReconstructSurface(PointCloud cloud, const MeshOptions& options,
                                 const std::string& what, Progress* progress,
                                 const WindowEvidence& windows) {
  SurfaceResult out;
  SubProgress filtering(progress, 0, 0.15);
  RequireMeshable(cloud, what);
  const double cell = kPoissonCubeScale * BulkExtent(cloud.points) /
                      std::pow(2.0, options.depth > 0 ? options.depth : options.max_depth);
  out.used = FilterPoints(std::move(cloud), options.filter, options.merge * cell, what, &filtering);
  out.depth = options.depth > 0 ? options.depth
                                : DepthForSampling(BoundingDiagonal(out.used.cloud.points),
                                                   out.used.median_spacing, options.max_depth);
  ReportProgress(progress, 0.15, "fitting the surface");
  PoissonOptions poisson = options.poisson;
  poisson.depth = out.depth;
  Mesh surface = Fit(out.used, poisson);
  const double finest = CellSize(out.used.cloud.points, out.depth);
  if (const std::vector<SightLine> blocked = BlockedLines(surface, windows.lines);
      !blocked.empty()) {
    ReportProgress(progress, 0.5, "opening windows");
    out.views_with_closed_window = ViewCount(blocked);
    out.window_points = AddWindowWalls(surface, blocked, windows.read_outside(), finest, &out.used);
    if (out.window_points > 0) surface = Fit(out.used, poisson);
  }
  out.poisson_faces = surface.face_count();

  ReportProgress(progress, 0.85, "trimming");
  TrimResult trimmed = TrimToData(surface, out.used, finest, options.trim);
  out.trimmed_faces = trimmed.trimmed_faces;
  out.removed_components = trimmed.removed_components;
  out.kept_closures = trimmed.kept_closures;
  out.mesh = std::move(trimmed.mesh);
  ReportProgress(progress, 0.95, "colouring");
  out.mesh.colors = ColorsFromPoints(out.mesh, out.used);
  return out;
}

}  // namespace keypose::reconstruct
