// Where a repair changed a surface, and how far the rest of it moved.
#pragma once

#include "cleanup/strategies/cleanup_result.h"

namespace keypose::cleanup {

/// The faces that only one of two meshes has; corners are compared bit for bit, their order does
/// not count.
/// @return vertices of its own, three a face
Mesh ChangedFaces(const Mesh& before, const Mesh& after);

/// Fills undamaged_share, undamaged_to_input and undamaged_from_input: distances between `kept` and
/// `mesh`, sampled by area, without what lies within `reach` of `changed`.
void MeasureUndamaged(const Mesh& mesh, const Mesh& kept, const Mesh& changed, double reach,
                      CleanupResult& result);

}  // namespace keypose::cleanup
