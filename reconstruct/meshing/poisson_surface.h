// Screened Poisson surface reconstruction from oriented points.
#pragma once

#include "core/mesh.h"

namespace keypose::reconstruct {

/// The octree's cube is this times the points' largest extent: room for closures to bulge.
constexpr double kPoissonCubeScale = 1.25;

struct PoissonOptions {
  int depth = 8;  ///< octree levels; cells are kPoissonCubeScale x largest extent / 2^depth wide
  /// how strongly the surface is held to the points; 0 is the unscreened method
  double point_weight = 4;
  /// points wanted in a leaf; 1 to 5 for clean clouds, 10 to 20 for noisy ones
  double samples_per_node = 2;
};

/// The zero set of the indicator function that fits the oriented points: closed except where it
/// leaves the cube. Works in single precision inside, on points moved and scaled to the unit cube:
/// expect 1e-6 of the extent.
///
/// @param points   P x 3, finite, not all the same
/// @param normals  P x 3 unit, pointing outside
/// @param weights  P in (0, 1], or empty for all one: a normal's say among those near it. A lone
/// point of low weight still holds the surface, at
///                 a coarser level of the octree. The screening counts points and does not see
///                 weights: thin out what should pull less.
/// @return positions and faces, counter-clockwise seen from where the normals point; faces with a
/// repeated corner are left out
/// @throws SolverError  no surface came out
/// One thread, so the same bits everywhere. Needs about 1 GiB at depth 9 and cannot be interrupted.
/// Source: Kazhdan & Hoppe, Screened Poisson Surface Reconstruction, TOG 2013 (PCL's build of it).
Mesh ScreenedPoisson(const PointsX3& points, const PointsX3& normals,
                     const Eigen::VectorXf& weights, const PoissonOptions& options);

}  // namespace keypose::reconstruct
