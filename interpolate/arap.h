// As-rigid-as-possible interpolation between two keys of one connectivity.
#pragma once

#include <memory>
#include <vector>

#include "core/mesh.h"

namespace keypose::interpolation {

struct ArapOptions {
  bool symmetric = true;     ///< energies of both directions together; else from the first key only, as in the paper
  bool log_stretch = true;   ///< S^t; else (1-t) I + t S, as in the paper
  bool follow_turns = true;  ///< neighbours turn the same way round (see below); else every face takes its shortest turn
};

/// Frames between keys V and U: each triangle's map is split into turn and stretch, both are taken to the power t, and vertices are fitted.
///
/// One Laplacian (of both keys) is factored once; its right-hand side per t comes from the wanted edges, in divergence form. Each connected
/// part keeps its centroid on the path that the whole body's turn gives it. At(0) and At(1) give the keys to solver precision.
/// follow_turns grows a tree over neighbouring faces, least difference first, and adds to each face the whole turns that bring its rotation
/// vector nearest to its parent's, so that a bend beyond 180 degrees does not tear where the shortest turn changes side. Cost: one
/// factorisation of V x V, one solve with three right-hand sides a frame. Same bits for any thread count. Source: Ebner et al.,
/// E-StopMotion, section 4.2; Alexa et al. 2000; Baxter et al. 2008. Reduced from (V+F) to V unknowns: the free fourth vertices leave
/// exactly the cotangent Laplacian. Departs: symmetric energy, log stretch.
class ArapInterpolator {
 public:
  /// @throws InputError   other numbers of vertices, unusable mesh
  /// @throws SolverError  the Laplacian cannot be factored
  ArapInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces, const ArapOptions& options = {});
  ~ArapInterpolator();
  ArapInterpolator(ArapInterpolator&&) noexcept;

  PointsX3 At(double t) const;
  /// Several frames with one batch of solves.
  std::vector<PointsX3> At(const std::vector<double>& times) const;

  int degenerate_faces() const;
  double largest_turn() const;  ///< of any face [rad]; beyond pi only with follow_turns

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

PointsX3 InterpolateLinearly(const PointsX3& v, const PointsX3& u, double t);

}  // namespace keypose::interpolation
