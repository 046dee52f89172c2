// To a wanted number of faces: quadric-like decimation, and uniform remeshing.
#pragma once

#include "core/mesh.h"

namespace keypose::cleanup {

/// Collapses edges, cheapest first, until at most `faces` are left (or no edge can go without breaking the manifold).
///
/// @param manifold  oriented 2-manifold, possibly with boundary
/// @param even      true: shortest edge first, keeps triangles equal; false: least change of shape and volume first
/// Source: Lindstrom & Turk, IEEE Visualization 1998, by CGAL; collapses that flip a normal are refused.
Mesh Decimated(const Mesh& manifold, int faces, bool even);

/// Nearly equilateral triangles of nearly equal size on the same surface, about `faces` of them.
///
/// @param closed  closed oriented 2-manifold
/// Source: Botsch & Kobbelt, SGP 2004, by CGAL.
Mesh UniformlyRemeshed(const Mesh& closed, int faces, int iterations);

}  // namespace keypose::cleanup
