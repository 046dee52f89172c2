// Any heap of triangles to an oriented 2-manifold, possibly with boundary: the first of the repair
// strategies, R0.
#pragma once

#include "core/mesh.h"

namespace keypose::cleanup {

struct SoupResult {
  Mesh mesh;  ///< positions and faces only; every edge has one or two faces, every vertex one fan;
              ///< no unused vertex
  int merged_vertices = 0;  ///< vertices welded into another
  int dropped_faces = 0;    ///< faces with a repeated corner or the corners of an earlier face
};

/// Welds vertices nearer than `weld_radius` to each other, drops degenerate and duplicate faces,
/// orients neighbours alike, and cuts the surface where more than two faces share an edge or a
/// vertex has more than one fan.
///
/// @throws InputError  no face is left
/// Source: the polygon soup tools of CGAL's Polygon Mesh Processing; welding is ours.
SoupResult OrientedManifold(const Mesh& soup, double weld_radius);

/// Sews boundary edges with equal end points together where that keeps the mesh a manifold.
Mesh Stitched(const Mesh& manifold);

}  // namespace keypose::cleanup
