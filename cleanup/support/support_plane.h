// Turntables, plates, table cloths: the flat thing that a figure stands on, found and cut off.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mesh.h"

namespace keypose::cleanup {

/// Keep what has normal . x >= offset.
struct CutPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;
};

/// The plane a little above a level sheet near the bottom (z up, tilted by 12 degrees at most) on
/// which the rest stands; nothing when in doubt.
///
/// A sheet counts when it spreads over at least 1.5 times the figure's cross-section just above it
/// (both by their convex hulls), at least half of what it spreads beyond the figure is really
/// there, it is flat within 0.6 % of the diagonal, and nothing hangs lower than 12 % of it.
/// @param mesh  any triangles; orientation does not matter
std::optional<CutPlane> FindSupport(const Mesh& mesh);

/// What lies above the plane; faces that it crosses are split, and the new border lies exactly on
/// it.
Mesh ClippedAbove(const Mesh& mesh, const CutPlane& plane);

}  // namespace keypose::cleanup
