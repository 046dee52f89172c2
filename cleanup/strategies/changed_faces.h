// Finds where a repair changed a surface, and measures how far the rest of it moved.
#pragma once

#include "cleanup/strategies/cleanup_result.h"

namespace keypose::cleanup {

/// The faces that only one of two meshes has. Their corners are compared bit for bit, in any order.
/// @return a mesh with three vertices of its own for each face
Mesh ChangedFaces(const Mesh& before, const Mesh& after);

/// Fills undamaged_share, undamaged_to_input and undamaged_from_input of the result: distances
/// between `kept` and `mesh`, sampled by area. Samples within `reach` of `changed` are left out.
void MeasureUndamaged(const Mesh& mesh, const Mesh& kept, const Mesh& changed, double reach,
                      CleanupResult& result);

}  // namespace keypose::cleanup
