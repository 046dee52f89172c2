// Remeshing to edge lengths that vary over the surface, and to an exact number of faces.
#pragma once

#include <Eigen/Core>

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// Remeshes the surface with nearly equilateral triangles whose edges have the wanted lengths.
///
/// @param start  closed oriented 2-manifold near the surface; remeshing starts from its
/// connectivity
/// @param surface  closed oriented 2-manifold; the vertices are put on it
/// @param sizes    wanted edge length at each vertex of `surface`; only their ratios count
/// @param faces  wanted number of faces, rounded to an even number; reached when the edges allow it
/// @return closed oriented 2-manifold with the start's topology; may intersect itself where two
/// walls are nearer to each other than the edge length: check it
/// Source: Botsch & Kobbelt, SGP 2004; Dunyach et al., Eurographics 2013 (sizes).
/// Departs: a collapse goes to the end or the midpoint of the edge that is nearest to the planes of
/// the surrounding faces; edges are flipped to improve angles, not valence; the number of faces is
/// controlled. Finally vertices are fitted to the surface, edges across a ridge are flipped to run
/// along it, and the vertices of thin faces are moved to improve their angles.
Mesh Remeshed(const Mesh& start, const Mesh& surface, const Eigen::VectorXd& sizes, int faces);

/// Flips and collapses edges and moves vertices until no angle is below `least_deg`, as far as that
/// is possible without turning a face over. The number of faces may fall slightly. Vertices away
/// from thin faces do not move.
Mesh WithoutThinAngles(const Mesh& closed, double least_deg);

/// Splits the longest edges until there are `faces` faces. The shape does not change.
Mesh SplitTo(const Mesh& closed, int faces);

}  // namespace keypose::cleanup
