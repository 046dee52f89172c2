// Turns any triangles into an oriented 2-manifold, possibly with boundary: the first repair
// strategy, R0.
#pragma once

#include "core/values/mesh.h"

namespace keypose::cleanup {

struct SoupResult {
  Mesh mesh;  ///< positions and faces only; every edge has one or two faces, every vertex has one
              ///< fan; no unused vertices
  int merged_vertices = 0;  ///< vertices that were merged into another one
  int dropped_faces = 0;  ///< faces with a repeated vertex or the same vertices as an earlier face
};

/// Merges vertices nearer than `weld_radius` to each other, drops degenerate and duplicate faces,
/// orients neighbouring faces consistently, and cuts the surface where more than two faces share an
/// edge or a vertex has more than one fan.
///
/// @throws InputError  no face is left
/// Source: the polygon soup tools of CGAL's Polygon Mesh Processing; the merging is our own.
SoupResult OrientedManifold(const Mesh& soup, double weld_radius);

/// Joins boundary edges with equal end points where the mesh stays a manifold.
Mesh Stitched(const Mesh& manifold);

}  // namespace keypose::cleanup
