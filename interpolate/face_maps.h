// The map of each triangle from one key to the next, split into turn and stretch.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"

namespace keypose::interpolation {

/// Proper 2x2 polar decomposition J = R P of a matrix with det > 0, in closed form.
struct Polar2 {
  double cosine = 1, sine = 0;  ///< R = [c -s; s c]
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
};
Polar2 PolarOf(const Eigen::Matrix2d& j);

/// exp(t log S) of a symmetric positive definite 2x2 matrix, from its eigenvectors.
Eigen::Matrix2d PowerOf(const Eigen::Matrix2d& symmetric, double t);

/// One triangle's map V -> U as U-edge = rotation * frame * stretch * frame^T * V-edge.
struct FaceMap {
  Eigen::Matrix<double, 3, 2> frame;  ///< orthonormal, spans the triangle in V
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();       ///< rotation vector; |turn| <= pi until MakeTurnsConsistent
  Eigen::Vector3d remainder = Eigen::Vector3d::Zero();  ///< rotation = exp(turn) exp(remainder)
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
  bool degenerate = false;  ///< no area in V or U: no map; its edges go straight
};

/// Rotation vector of a rotation matrix, |w| <= pi, exact near 0 and near pi.
Eigen::Vector3d LogOf(const Eigen::Matrix3d& rotation);
Eigen::Matrix3d ExpOf(const Eigen::Vector3d& turn);

/// @param v, u  V x 3 with the same faces
/// Faces whose doubled area is below 1e-6 of their longest edge squared, in either key, come out `degenerate`.
/// Source: polar decomposition as in Alexa et al., SIGGRAPH 2000; the in-plane form equals that of the paper's surface tetrahedra, whose
/// fourth vertex only adds a stretch along the normal.
std::vector<FaceMap> FaceMapsOf(const PointsX3& v, const PointsX3& u, const FacesX3& faces);

}  // namespace keypose::interpolation
