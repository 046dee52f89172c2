// A closed surface around any triangles: the last repair strategy, R4.
#pragma once

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// The surface around the space that a ball of radius `alpha` cannot reach from outside, at a
/// distance of `offset` from the input.
///
/// @param soup    any triangles; gaps narrower than about 2 * alpha are bridged
/// @param alpha   [units of the points] > 0; radius of the largest empty ball at a face of the
/// result
/// @param offset  [units of the points] > 0; how far outside of the input the result lies
/// @return closed, oriented, without self-intersections, vertices at most one fan
/// Source: Portaneri, Rouxel-Labbe, Hemmer, Cohen-Steiner, Alliez, SIGGRAPH 2022, by CGAL.
Mesh AlphaWrap(const Mesh& soup, double alpha, double offset);

/// Moves a wrap back onto the wrapped surface, where that lies below it (within 45 degrees of the
/// normal) and within `reach`.
///
/// @param reach  [units of the points] no vertex moves farther
/// @return the same faces as `wrap`; vertices do not move where faces would intersect or flip
Mesh ProjectedBack(const Mesh& wrap, const Mesh& soup, double reach);

}  // namespace keypose::cleanup
