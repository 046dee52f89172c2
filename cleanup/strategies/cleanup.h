// Any triangle mesh to a closed, oriented 2-manifold without self-intersections, at a wanted size.
#pragma once

#include <optional>
#include <vector>

#include "cleanup/strategies/cleanup_options.h"
#include "cleanup/strategies/cleanup_result.h"
#include "core/mesh.h"
#include "core/progress.h"
#include "core/sight_lines.h"

namespace keypose::cleanup {

/// Repairs by the least destructive means that pass the test: closed, oriented, one fan a vertex,
/// positive volume, no face without area, no two faces that intersect (exact predicates).
///
/// @param surface  any triangles with finite vertices; colours optional
/// @param lines    what photographs see through the figure (LinesThroughHoles), in the surface's
/// frame; without them no handle is kept
///                 unless options.genus says so
/// @param ground   height along z on which the figure stands (StandsOnGround): what lies below
/// goes, and the soles are flat there
/// @throws InputError    empty or not finite, says where; or nothing with a volume can be made of
/// it; or fewer handles than options.genus
/// @throws QualityError  every strategy failed; says what the last one lacked
/// A mesh that passes already, with `keep_components` pieces, the wanted genus and not more than
/// `faces` faces, is returned bit for bit.
/// Cost: about 5 s for 300,000 faces to 20,000, 18 s for 2 million.
/// Same bits for any thread count.
/// Source: the order is ours; each strategy's source stands in its header.
CleanupResult MakeClosedManifold(const Mesh& surface, const CleanupOptions& options,
                                 Progress* progress = nullptr,
                                 const std::vector<SightLine>& lines = {},
                                 const std::optional<double>& ground = {});

}  // namespace keypose::cleanup
