// The map of each triangle from one key to the next, split into turn and stretch.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/numbers/rotations.h"
#include "core/values/mesh.h"

namespace keypose::interpolation {

/// Proper 2x2 polar decomposition J = R P of a matrix with det > 0, in closed form.
struct Polar2 {
  double cosine = 1, sine = 0;  ///< R = [c -s; s c]
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
};
Polar2 PolarOf(const Eigen::Matrix2d& j);

/// exp(t log S) of a symmetric positive definite 2x2 matrix, from its eigenvectors.
Eigen::Matrix2d PowerOf(const Eigen::Matrix2d& symmetric, double t);

/// How a triangle's stretch S changes from I to S.
enum class Stretch {
  kLinear,       ///< (1-t) I + t S, as in the paper
  kLogarithmic,  ///< S^t: geometric growth
  /// e^(t g) (e^-g S)^tau(t). g is the growth of the region around the triangle; tau makes the rest
  /// of the triangle's area change linearly. So a region grows geometrically and a shear follows
  /// its geodesic. A bend, whose inside shrinks as its outside grows, keeps its total area and the
  /// arc's own strain. Exact for uniform growth and for pure bends, third order in shear.
  kBalanced,
};

/// One triangle's map V -> U as U-edge = rotation * frame * stretch * frame^T * V-edge.
struct FaceMap {
  Eigen::Matrix<double, 3, 2> frame;  ///< orthonormal, spans the triangle in V
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  /// rotation vector [rad]; of any length after FollowTurns
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  /// rotation = exp(body_turn) exp(turn) exp(remainder)
  Eigen::Vector3d remainder = Eigen::Vector3d::Zero();
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
  double growth = 0;        ///< log of the region's linear scale, U over V; 0 until set
  bool degenerate = false;  ///< no area in V or U: no map, and its edges are interpolated linearly
};

/// All faces' maps from one key to the next.
struct SegmentMaps {
  std::vector<FaceMap> faces;
  Eigen::Vector3d body_turn = Eigen::Vector3d::Zero();
  PointsX3 vertex_turns;  ///< V x 3, turns smoothed over the surface; empty until FollowTurns
  /// rotations come from DifferentialTurns; turn and remainder are not valid
  bool differential = false;
};

/// tau of Stretch::kBalanced for log-area x relative to the region: 0 at t = 0, 1 at t = 1, tau(t,
/// x) + tau(1-t, -x) = 1.
double BalancedTime(double t, double x);

/// @param v, u  V x 3 with the same faces
/// Faces whose doubled area is below 1e-6 of their longest edge squared, in either key, are marked
/// `degenerate`. turn is the shortest rotation vector; remainder and body_turn are zero.
/// Source: polar decomposition as in Alexa et al., SIGGRAPH 2000; the in-plane form equals that of
/// the paper's surface tetrahedra, whose fourth vertex only adds a stretch along the normal.
SegmentMaps FaceMapsOf(const PointsX3& v, const PointsX3& u, const FacesX3& faces);

/// Sets every face's turn to its shortest rotation vector, independent of its neighbours.
void ShortestTurns(SegmentMaps& maps);

}  // namespace keypose::interpolation
