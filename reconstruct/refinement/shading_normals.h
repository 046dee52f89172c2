// Normals from shading: a turntable turns the figure under fixed lamps, so each vertex is seen
// under light from many directions.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "reconstruct/refinement/displacement_solve.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct ShadingNormals {
  /// V x 3 unit: the surface's own, rotated to the fine detail that shading shows
  PointsX3 normals;
  /// in [0, 1]: how well the photographs determine the rotation; 0: not at all
  std::vector<float> weight;
  double residual_before = 0;  ///< median relative error of brightness with the surface's normals
  double residual_after = 0;   ///< and with these normals
};

/// Each view's light is a polynomial of second degree in the normal, fitted to the view's pixels
/// with the surface's normals. Each vertex has an albedo. The normals that fit the brightness best
/// are estimated vertex by vertex. Errors from shadows, near lamps and light from other parts of
/// the figure vary slowly over the surface, so slowly varying rotations are removed: the vertex
/// positions are more accurate for those.
///
/// @param views    with colours
/// @param sights   from AllSights
/// @param smooth   rounds of Diffuse that separate slow variation
/// Source: Hernandez, Vogiatzis, Cipolla, PAMI 2008, and Nehab et al., SIGGRAPH 2005.
/// Departs: light of any distribution, by view.
ShadingNormals NormalsFromShading(const Mesh& mesh, const PointsX3& normals,
                                  const Neighbors& neighbors,
                                  const std::vector<PreparedView>& views,
                                  const std::vector<std::vector<float>>& sights, int smooth);

}  // namespace keypose::reconstruct
