// Screened Poisson surface reconstruction from oriented points.
#pragma once

#include "core/values/mesh.h"

namespace keypose::reconstruct {

/// Edge of the octree's cube over the points' largest extent: leaves space for closures to bulge.
constexpr double kPoissonCubeScale = 1.25;

struct PoissonOptions {
  int depth = 8;  ///< octree levels; cells are kPoissonCubeScale x largest extent / 2^depth wide
  /// weight of the points in the fit; 0 is the unscreened method
  double point_weight = 4;
  /// least number of points in a leaf; 1 to 5 for clean clouds, 10 to 20 for noisy ones
  double samples_per_node = 2;
};

/// The zero set of the indicator function that fits the oriented points. It is closed except where
/// it leaves the cube. Computed in single precision on points moved and scaled to the unit cube:
/// expect an accuracy of 1e-6 of the extent.
///
/// @param points   P x 3, finite, not all the same
/// @param normals  P x 3 unit, pointing outwards
/// @param weights  P in (0, 1], or empty for all one: the weight of a normal among those near it.
/// An isolated point of low weight still attracts the surface, at a coarser level of the octree.
/// The screening counts points and ignores weights: remove points that should have less influence.
/// @return positions and faces, counter-clockwise seen from where the normals point; faces with a
/// repeated corner are left out
/// @throws SolverError  the result is empty
/// Single-threaded, so the same bits everywhere. Needs about 1 GiB at depth 9 and cannot be
/// interrupted.
/// Source: Kazhdan & Hoppe, Screened Poisson Surface Reconstruction, TOG 2013 (PCL's version of
/// it).
Mesh ScreenedPoisson(const PointsX3& points, const PointsX3& normals,
                     const Eigen::VectorXf& weights, const PoissonOptions& options);

}  // namespace keypose::reconstruct
