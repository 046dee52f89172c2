// A slab with windows, and photographs of it.
#pragma once

#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/pictures/sight_lines.h"
#include "core/surfaces/ray_scene.h"
#include "core/testing/shots.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "core/values/size_of.h"

namespace keypose::cleanup {

using Cell = std::tuple<int, int, int>;

constexpr int kWide = 21, kHigh = 9,
              kDeep = 2;  // cells of the slab; it stands upright and is seen from the front, -y

/// Cells [x0, x1) x [z0, z1) that are open.
struct Window {
  int x0, x1, z0, z1;
  Eigen::RowVector3d Middle() const { return {(x0 + x1) / 2.0, kDeep / 2.0, (z0 + z1) / 2.0}; }
};

/// The boundary of an upright slab of unit cells with windows, each square in two triangles.
inline Mesh Slab(const std::vector<Window>& windows) {
  std::set<Cell> cells;
  for (int x = 0; x < kWide; ++x)
    for (int y = 0; y < kDeep; ++y)
      for (int z = 0; z < kHigh; ++z) {
        bool open = false;
        for (const Window& w : windows)
          open = open || (x >= w.x0 && x < w.x1 && z >= w.z0 && z < w.z1);
        if (!open) cells.insert({x, y, z});
      }
  std::map<Cell, int> ids;
  std::vector<Eigen::RowVector3d> points;
  std::vector<Eigen::RowVector3i> faces;
  const auto corner = [&](const Eigen::Vector3i& p) {
    const auto [it, is_new] = ids.try_emplace({p[0], p[1], p[2]}, SizeOf(points));
    if (is_new) points.push_back(p.cast<double>().transpose());
    return it->second;
  };
  for (const auto& [x, y, z] : cells)
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        Eigen::Vector3i next(x, y, z);
        next[axis] += 2 * side - 1;
        if (cells.contains({next[0], next[1], next[2]})) continue;
        const Eigen::Vector3i base = Eigen::Vector3i(x, y, z) + side * Eigen::Vector3i::Unit(axis),
                              u = Eigen::Vector3i::Unit((axis + 1) % 3),
                              v = Eigen::Vector3i::Unit((axis + 2) % 3);
        const int a = corner(base), b = corner(base + u), c = corner(base + u + v),
                  d = corner(base + v);
        faces.push_back(side ? Eigen::RowVector3i(a, b, c) : Eigen::RowVector3i(a, c, b));
        faces.push_back(side ? Eigen::RowVector3i(a, c, d) : Eigen::RowVector3i(a, d, c));
      }
  Mesh mesh;
  mesh.points.resize(std::ssize(points), 3);
  mesh.faces.resize(std::ssize(faces), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.points.row(i) = points[i];
  for (std::size_t i = 0; i < faces.size(); ++i) mesh.faces.row(i) = faces[i];
  return mesh;
}

inline MaskShot PhotographOfSlab(const Mesh& truth, const std::vector<double>& azimuths_deg) {
  std::vector<View> views;
  for (const double azimuth : azimuths_deg) {
    views.push_back(FitView(truth.points, azimuth, 5, 320, 240));
    views.back().name = "IMG_" + std::to_string(1000 + views.size()) + ".png";
  }
  return MasksOf(truth, std::move(views));
}

inline std::vector<SightLine> LinesOf(const MaskShot& shot) {
  return LinesThroughHoles(shot.views, shot.masks);
}

inline bool Open(const Mesh& mesh, const Window& window) {
  const RayScene scene(mesh.points, mesh.faces);
  const Eigen::Vector3d middle = window.Middle().transpose();
  return !scene.Occluded(middle - Eigen::Vector3d(0, 50, 0), {0, 1, 0}, 0, 100);
}

}  // namespace keypose::cleanup
