// Remeshing to sizes that differ from place to place, and to an exact number of faces.
#pragma once

#include <Eigen/Core>

#include "core/mesh.h"

namespace keypose::cleanup {

/// Triangles as equilateral as may be, with edges of the wanted sizes, on the given surface.
///
/// @param start    closed oriented 2-manifold near the surface; its connectivity is where the work
/// begins
/// @param surface  closed oriented 2-manifold; what the vertices are put on
/// @param sizes    wanted edge length at each vertex of `surface`; only their ratios count
/// @param faces    how many there will be, to the next even number where edges allow
/// @return closed oriented 2-manifold of the start's topology; may intersect itself where walls are
/// nearer than edges are long: check it Source: Botsch & Kobbelt, SGP 2004; Dunyach et al.,
/// Eurographics 2013 (sizes).
/// Departs: collapses go to the end or the middle that lies nearest to the planes around, edges are
/// flipped for angles and not for valence, and the count is steered. At last the vertices are
/// fitted, edges that run across a ridge are turned along it, and thin faces slide to where they
/// are thicker.
Mesh Remeshed(const Mesh& start, const Mesh& surface, const Eigen::VectorXd& sizes, int faces);

/// Flips, collapses and shifts until no angle is below `least_deg`, where that is possible without
/// turning a face. The number of faces may fall by a few. Vertices away from slivers do not move.
Mesh WithoutThinAngles(const Mesh& closed, double least_deg);

/// Splits the longest edges until there are `faces` faces; the surface stays what it is.
Mesh SplitTo(const Mesh& closed, int faces);

}  // namespace keypose::cleanup
