// Finds the flat support of a figure, such as a turntable, base or tablecloth, and cuts it off.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// The part with normal . x >= offset is kept.
struct CutPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;
};

/// Looks for a flat sheet near the bottom (z up, tilted by at most 12 degrees) on which the rest
/// stands. Returns a plane slightly above it; nothing when in doubt.
///
/// A sheet is a support under five conditions. The area of its convex hull is at least 1.5 times
/// that of the figure's cross-section just above it. At least half of the area beyond the figure is
/// covered by faces. It is flat to 0.6 % of the diagonal. Nothing is lower than it by more than 12
/// % of the diagonal. The mesh rises above it by at least 10 % of the diagonal, and by twice the
/// depth of what is below.
/// @param mesh  any triangles; orientation does not matter
std::optional<CutPlane> FindSupport(const Mesh& mesh);

/// The part above the plane. Faces that cross it are split, and the new border lies exactly on it.
Mesh ClippedAbove(const Mesh& mesh, const CutPlane& plane);

}  // namespace keypose::cleanup
