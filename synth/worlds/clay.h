// Clay figures as implicit solids: lumps of clay pressed together, with finger dents, paint and
// fine grain.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace keypose::synth {

/// A round cone from a (radius ra) to b (radius rb), optionally flattened; a sphere when a == b.
/// Metres.
struct Lump {
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();
  double ra = 0.01, rb = 0.01;
  double blend = 0.005;  ///< [m] width of the fillet to the clay below it
  Eigen::Vector3d color = Eigen::Vector3d(0.7, 0.3, 0.2);  ///< linear RGB in [0,1]
  bool crisp = false;  ///< for eyes and buttons: no dents, almost no grain
};

/// A painted spot on one lump.
struct Spot {
  Eigen::Vector3d center;  ///< [m] rest pose
  double radius;           ///< [m]
  Eigen::Vector3d color;   ///< linear RGB
};

/// A solid {x : Distance(x) < 0} and its paint, in the rest pose. z is up; it stands on the plane z
/// = 0 and faces -y. Metres.
struct Clay {
  std::vector<Lump> lumps;
  std::vector<Spot> spots;
  double dent_depth = 0.0005;     ///< [m] of the thumb marks
  double dent_size = 0.011;       ///< [m] wavelength of the thumb marks
  double grain = 1;               ///< contrast of the fine paint grain; 1: rich, about 0.12: weak
  double grain_size = 1;          ///< scale of all grain wavelengths
  double ridge_height = 0.00004;  ///< [m] of finger-print ridges
  double ridge_spacing = 0.0012;  ///< [m] from crest to crest
  bool flat_base = true;          ///< cut at z = 0
  std::uint32_t seed = 1;

  /// Approximate signed distance [m], negative inside. Lipschitz constant at most 1.3.
  double Distance(const Eigen::Vector3d& x) const;
  Eigen::Vector3d Gradient(const Eigen::Vector3d& x) const;
  /// Index of the lump that a point of the surface belongs to.
  int LumpAt(const Eigen::Vector3d& x) const;
  /// Linear RGB of the paint at a point of the surface that belongs to `lump`.
  Eigen::Vector3d Paint(const Eigen::Vector3d& x, int lump) const;
  /// Height of the finger-prints above the solid's surface [m]. Distance() does not include them:
  /// the world moves its vertices by them, or only tilts their shading normals.
  double RidgeHeight(const Eigen::Vector3d& x, int lump) const;
  /// Gradient of the ridges' height at a point, dimensionless. It tilts the shading normal.
  Eigen::Vector3d RidgeSlope(const Eigen::Vector3d& x, int lump) const;
  /// Bounding box of the solid, with a margin.
  void Bounds(Eigen::Vector3d* low, Eigen::Vector3d* high) const;
};

}  // namespace keypose::synth
