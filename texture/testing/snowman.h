// A figure with a deep crease.
#pragma once

#include <cmath>

#include "core/surfaces/shapes.h"
#include "core/values/mesh.h"

namespace keypose::texture {

/// Two balls, one on the other, with a deep crease around the waist at z = 0.
inline Mesh Snowman(int levels) {
  Mesh mesh = MakeIcosphere(levels);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double z = mesh.points(v, 2), narrow = 1 - 0.6 * std::exp(-z * z / 0.02);
    mesh.points(v, 0) *= narrow;
    mesh.points(v, 1) *= narrow;
    mesh.points(v, 2) *= 1.8;
  }
  return mesh;
}

}  // namespace keypose::texture
