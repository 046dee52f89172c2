// A surface with waves that its photographs do not have.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/values/mesh.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct {

constexpr int kLevels = 2;
inline std::vector<PreparedView> Views(const testing::RenderedScene& scene) {
  return testing::Prepared(scene, kLevels);
}

inline const testing::RenderedScene& Painted() {
  static const testing::RenderedScene scene = testing::RenderRing({.views = 9});
  return scene;
}

// The true surface, displaced along its normals by smooth waves of `footprints`; vertices about two
// pixels apart.
inline Mesh Wavy(const testing::RenderedScene& scene, double footprints) {
  Mesh mesh = MakeIcosphere(5);
  const RayScene rays(scene.truth.points, scene.truth.faces);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d way = mesh.points.row(v).normalized();
    mesh.points.row(v) = rays.Cast(3 * way, -way).distance * -way + 3 * way;
  }
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d x = mesh.points.row(v);
    const double wave =
        std::sin(7 * x.x() + 1) * std::sin(6 * x.y() - 2) + std::sin(5 * x.z() + 3 * x.x());
    mesh.points.row(v) += footprints * scene.footprint * wave * normals.row(v);
  }
  return mesh;
}

}  // namespace keypose::reconstruct
