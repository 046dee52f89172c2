// The lowest vibrations of a surface: eigenfunctions of its Laplace-Beltrami operator.
#pragma once

#include <Eigen/Core>

#include "core/mesh.h"

namespace keypose::registration {

/// Orthonormal in the inner product of vertex areas; areas are scaled to sum 1, so values do not
/// depend on the mesh's size.
struct Spectrum {
  Eigen::VectorXd areas;      ///< V, positive, sum 1
  Eigen::VectorXd values;     ///< K, ascending, values[0] = 0 up to rounding
  Eigen::MatrixXd functions;  ///< V x K, functions^T diag(areas) functions = I; each one's largest
                              ///< entry is positive
};

/// @param count  wanted eigenfunctions; K = min(count, V - 1)
/// @throws InputError   no faces with area
/// @throws SolverError  the operator cannot be factored
/// Cost: one sparse factorisation and about 2.5 K solves. Deterministic.
/// Source: Pinkall and Polthier 1993 (cotangent weights, clamped from below); shift-invert block
/// Lanczos with full reorthogonalisation.
Spectrum LaplaceSpectrum(const PointsX3& points, const FacesX3& faces, int count);

}  // namespace keypose::registration
