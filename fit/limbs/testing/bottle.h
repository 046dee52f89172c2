// A bottle whose neck is a limb.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/surfaces/shapes.h"
#include "core/values/mesh.h"
#include "core/values/size_of.h"
#include "fit/limbs/limbs.h"

namespace keypose::fit {

constexpr double kNeck = 1.3, kWrist = 2.2, kTop = 3;

inline double Smooth(double from, double to, double at) {
  const double t = std::clamp((at - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Along z: a body of radius 1.8 up to the neck, an arm of radius 0.2, a flat hand with a thumb.
inline Mesh MakeBottle() {
  Mesh mesh = MakeCylinder(1, kTop, 20, 44);
  mesh.colors.resize(mesh.vertex_count(), 3);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double x = mesh.points(v, 0), y = mesh.points(v, 1), z = mesh.points(v, 2);
    const double closed = std::sqrt(std::max(0.0, std::min({1.0, z / 0.3, (kTop - z) / 0.25})));
    const double arm = Smooth(kNeck - 0.2, kNeck, z), hand = Smooth(kWrist, kWrist + 0.2, z);
    const double radius = closed * ((1 - arm) * 1.8 + arm * 0.2);
    const double thumb = x > 0 ? 0.3 * std::exp(-std::pow((z - 2.55) / 0.12, 2)) * x : 0;
    mesh.points(v, 0) = radius * x * (1 + 0.8 * hand) + closed * hand * thumb;
    mesh.points(v, 1) = radius * y * (1 - 0.3 * hand);
    if (hand > 0.5)
      mesh.colors.row(v) << 230, 190, y > 0 ? 60 : 150;
    else
      mesh.colors.row(v) << 110, 80, z > kNeck ? 170 : 90;
  }
  return mesh;
}

/// The limb that holds the bottle's top.
inline Limb ArmOf(const Mesh& mesh) {
  for (Limb& limb : FindLimbs(mesh.points, mesh.faces))
    for (const int v : limb.vertices)
      if (mesh.points(v, 2) > kTop - 0.05) return std::move(limb);
  ADD_FAILURE() << "no limb at the top";
  return {};
}

inline double MeanError(const PointsX3& a, const PointsX3& b, const std::vector<int>& vertices) {
  double sum = 0;
  for (const int v : vertices) sum += (a.row(v) - b.row(v)).norm();
  return sum / SizeOf(vertices);
}

}  // namespace keypose::fit
