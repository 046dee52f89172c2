// Turns any triangle mesh into a closed, oriented 2-manifold without self-intersections, with a
// wanted number of faces.
#pragma once

#include <optional>
#include <vector>

#include "cleanup/strategies/cleanup_options.h"
#include "cleanup/strategies/cleanup_result.h"
#include "core/pictures/sight_lines.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose::cleanup {

/// Repairs with the least destructive strategy whose result passes the test: closed, oriented, one
/// fan per vertex, positive volume, no face without area, no two faces that intersect (exact
/// predicates).
///
/// @param surface  any triangles with finite vertices; colours optional
/// @param lines    lines of sight through the figure (LinesThroughHoles), in the surface's frame;
///                 without them no handle is kept, unless options.genus asks for it
/// @param ground   height of the ground along z (StandsOnGround); everything below is removed, and
///                 the soles become flat there
/// @throws InputError    empty or not finite (says where); no surface with a volume can be made
///                       from it; or it has fewer handles than options.genus
/// @throws QualityError  every strategy failed; says why the last one failed
/// A mesh that already passes, with `keep_components` pieces, the wanted genus and at most `faces`
/// faces, is returned unchanged, bit for bit.
/// Cost: about 5 s for 300,000 faces to 20,000, 18 s for 2 million.
/// Same bits for any thread count.
/// Source: the order is our own; each strategy's header names its source.
CleanupResult MakeClosedManifold(const Mesh& surface, const CleanupOptions& options,
                                 Progress* progress = nullptr,
                                 const std::vector<SightLine>& lines = {},
                                 const std::optional<double>& ground = {});

}  // namespace keypose::cleanup
