// The lowest eigenfunctions of a surface's Laplace-Beltrami operator.
#pragma once

#include <Eigen/Core>

#include "core/values/mesh.h"

namespace keypose::registration {

/// Eigenvalues and eigenfunctions, orthonormal in the inner product of vertex areas. Areas are
/// scaled to sum 1, so the values do not depend on the size of the mesh.
struct Spectrum {
  Eigen::VectorXd areas;      ///< V, positive, sum 1
  Eigen::VectorXd values;     ///< K, ascending, values[0] = 0 up to rounding
  Eigen::MatrixXd functions;  ///< V x K, functions^T diag(areas) functions = I; each one's largest
                              ///< entry is positive
};

/// The lowest eigenvalues and eigenfunctions of a mesh.
/// @param count  wanted eigenfunctions; K = min(count, V - 1)
/// @throws InputError   no faces with area
/// @throws SolverError  the operator cannot be factored
/// Cost: one sparse factorisation and about 2.5 K solves. Deterministic.
/// Source: Pinkall and Polthier 1993 (cotangent weights, clamped from below); shift-invert block
/// Lanczos with full reorthogonalisation.
Spectrum LaplaceSpectrum(const PointsX3& points, const FacesX3& faces, int count);

}  // namespace keypose::registration
