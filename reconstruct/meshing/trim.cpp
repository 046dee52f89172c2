#include "reconstruct/meshing/trim.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"

namespace keypose::reconstruct {
namespace {

constexpr std::int64_t kTrimGrain = 2048;
constexpr int kColorNeighbors = 6;
// An isolated point has a large spacing, but must not keep a far surface.
constexpr double kLargestSpacing = 4;

std::vector<char> VerticesWithData(const Mesh& surface, const FilteredPoints& points, double cell,
                                   double trim) {
  const KdTree tree(points.cloud.points);
  std::vector<char> has_data(surface.vertex_count(), 0);
  ParallelBlocks(surface.vertex_count(), kTrimGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      const auto near = tree.Nearest(surface.points.row(v).transpose());
      const double spacing =
          std::min(points.spacing[near.index], kLargestSpacing * points.median_spacing);
      const double reach = trim * std::max(spacing, cell);
      has_data[v] = near.squared_distance <= reach * reach;
    }
  });
  return has_data;
}

// For each face with chosen != 0 the index of its connected part; -1 for the others.
std::vector<int> PartOfFaces(const Mesh& mesh, const std::vector<char>& chosen) {
  UnionFind parts(mesh.vertex_count());
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (!chosen[f]) continue;
    parts.Join(mesh.faces(f, 0), mesh.faces(f, 1));
    parts.Join(mesh.faces(f, 0), mesh.faces(f, 2));
  }
  std::vector<int> part(mesh.face_count(), -1);
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (chosen[f]) part[f] = parts.Find(mesh.faces(f, 0));
  }
  return part;
}

// Small patches without data are kept: Poisson closes them better than hole filling would.
int KeepSmallClosures(const Mesh& mesh, double share, std::vector<char>& keep) {
  std::vector<char> bare(keep.size());
  std::transform(keep.begin(), keep.end(), bare.begin(), [](char k) { return !k; });
  const std::vector<int> part = PartOfFaces(mesh, bare);
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  std::vector<double> area_of(mesh.vertex_count(), 0);
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (part[f] >= 0) area_of[part[f]] += areas[f];
  }
  const double limit = share * areas.sum();
  int kept = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (part[f] < 0 || area_of[part[f]] > limit) continue;
    keep[f] = 1;
  }
  for (double area : area_of) kept += area > 0 && area <= limit;
  return kept;
}

int DropSmallParts(const Mesh& mesh, double share, std::vector<char>& keep) {
  const std::vector<int> part = PartOfFaces(mesh, keep);
  std::vector<int> faces_of(mesh.vertex_count(), 0);
  for (int p : part) {
    if (p >= 0) ++faces_of[p];
  }
  const double limit = share * *std::max_element(faces_of.begin(), faces_of.end());
  for (std::size_t f = 0; f < keep.size(); ++f) {
    if (keep[f] && faces_of[part[f]] < limit) keep[f] = 0;
  }
  return static_cast<int>(
      std::count_if(faces_of.begin(), faces_of.end(), [&](int n) { return n > 0 && n < limit; }));
}

Mesh WithFaces(const Mesh& mesh, const std::vector<char>& keep) {
  std::vector<int> new_index(mesh.vertex_count(), -1);
  std::vector<int> kept_faces;
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (!keep[f]) continue;
    kept_faces.push_back(f);
    for (int k = 0; k < 3; ++k) new_index[mesh.faces(f, k)] = 0;
  }
  std::vector<int> kept_vertices;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (new_index[v] < 0) continue;
    new_index[v] = SizeOf(kept_vertices);
    kept_vertices.push_back(v);
  }
  Mesh out;
  out.points = mesh.points(kept_vertices, Eigen::all);
  out.faces = mesh.faces(kept_faces, Eigen::all).unaryExpr([&](int v) { return new_index[v]; });
  return out;
}

}  // namespace

TrimResult TrimToData(const Mesh& surface, const FilteredPoints& points, double cell,
                      const TrimOptions& options) {
  TrimResult out;
  std::vector<char> keep(surface.face_count(), 1);
  if (options.trim > 0) {
    const std::vector<char> has_data = VerticesWithData(surface, points, cell, options.trim);
    for (int f = 0; f < surface.face_count(); ++f) {
      keep[f] = has_data[surface.faces(f, 0)] && has_data[surface.faces(f, 1)] &&
                has_data[surface.faces(f, 2)];
    }
    out.kept_closures = KeepSmallClosures(surface, options.keep_area, keep);
    out.trimmed_faces = static_cast<int>(std::count(keep.begin(), keep.end(), 0));
  }
  if (std::find(keep.begin(), keep.end(), 1) == keep.end())
    throw SolverError(
        "mesh: no part of the surface lies near the points; check that the normals point outside, "
        "or raise `trim`");
  out.removed_components = DropSmallParts(surface, options.min_component, keep);
  out.mesh = WithFaces(surface, keep);
  return out;
}

ColorsX3 ColorsFromPoints(const Mesh& surface, const FilteredPoints& points) {
  if (points.cloud.colors.rows() == 0) return {};
  const KdTree tree(points.cloud.points);
  const PointsX3 normals = VertexNormals(surface.points, surface.faces);
  const double floor = 1e-6 * points.median_spacing * points.median_spacing;
  ColorsX3 colors(surface.vertex_count(), 3);
  ParallelBlocks(surface.vertex_count(), kTrimGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      // Two sums: over facing points, and over all points for the rare vertex without facing ones.
      Eigen::RowVector3d sum[2] = {Eigen::RowVector3d::Zero(), Eigen::RowVector3d::Zero()};
      double weight[2] = {0, 0};
      for (const auto& near : tree.Nearest(surface.points.row(v).transpose(), kColorNeighbors)) {
        const double w = 1 / (near.squared_distance + floor);
        const bool facing = points.cloud.normals.row(near.index).dot(normals.row(v)) > 0;
        for (int s = facing ? 0 : 1; s < 2; ++s) {
          sum[s] += w * points.cloud.colors.row(near.index).cast<double>();
          weight[s] += w;
        }
      }
      const int s = weight[0] > 0 ? 0 : 1;
      colors.row(v) = (sum[s] / weight[s]).array().round().min(255).max(0).cast<std::uint8_t>();
    }
  });
  return colors;
}

}  // namespace keypose::reconstruct
