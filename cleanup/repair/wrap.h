// A closed surface around anything: the last of the repair strategies, R4.
#pragma once

#include "core/mesh.h"

namespace keypose::cleanup {

/// The surface of what a ball of radius `alpha` cannot reach from outside, `offset` away from the
/// input.
///
/// @param soup    any triangles; gaps narrower than about 2 * alpha are bridged
/// @param alpha   [units of the points] > 0; the largest empty ball at a face of the result
/// @param offset  [units of the points] > 0; how far outside of the input the result lies
/// @return closed, oriented, without self-intersections, vertices at most one fan
/// Source: Portaneri, Rouxel-Labbe, Hemmer, Cohen-Steiner, Alliez, SIGGRAPH 2022, by CGAL.
Mesh AlphaWrap(const Mesh& soup, double alpha, double offset);

/// Pulls a wrap back onto what it wraps, where the surface lies straight below (within 45 degrees)
/// and not beyond `reach`.
///
/// @param reach  [units of the points] no vertex moves farther
/// @return same faces as `wrap`; vertices whose move would make faces intersect, or flip, stay
/// where they were
Mesh ProjectedBack(const Mesh& wrap, const Mesh& soup, double reach);

}  // namespace keypose::cleanup
