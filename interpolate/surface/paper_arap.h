// The paper's interpolation exactly: surface tetrahedra, V+F unknowns, linear stretch, energy of
// the first key only.
#pragma once

#include <memory>

#include "core/values/mesh.h"

namespace keypose::interpolation {

/// Every triangle gets a fourth vertex at its centroid + n / sqrt(|n|). V_T^* is the first three
/// rows of the inverse of its 4x4 matrix. A_T = V_T^* U_T is split into S R (row vectors: stretch
/// first) by a singular value decomposition, and A_T(t) = ((1-t) I + t S) R^t. The (V+F) x (V+F)
/// normal equations of sum_T a_T |V_T^* V(t) - A_T(t)|^2 are factored once. One vertex of each part
/// is fixed, and the part's vertex centroid moves on a straight line.
/// Source: Ebner et al., E-StopMotion, Eq. 6-9 (whose signs and transposes are inexact; the normal
/// equations follow from Eq. 6). Kept as the reference for ArapInterpolator and for comparison; it
/// has three times as many unknowns.
class PaperInterpolator {
 public:
  /// @throws InputError   unusable mesh, different numbers of vertices, or a triangle without area
  /// (named)
  /// @throws SolverError
  PaperInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces);
  ~PaperInterpolator();
  PaperInterpolator(PaperInterpolator&&) noexcept;
  PointsX3 At(double t) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::interpolation
