// Normals from shading: a turntable turns an object under lamps that stand still, so each place is
// seen in the light of many directions.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "reconstruct/refinement/displacement_solve.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct ShadingNormals {
  PointsX3 normals;  ///< V x 3 unit: the surface's own, turned by what shading says of fine detail
  /// in [0, 1]: how much of a turn the photographs tell; 0 where they say nothing
  std::vector<float> weight;
  double residual_before = 0;  ///< median relative error of brightness with the surface's normals
  double residual_after = 0;   ///< and with these
};

/// Each view's light is a polynomial of second degree of the normal, fitted to what it sees with
/// the surface's normals; each vertex has a brightness of its own. Normals that explain the
/// brightness best are found a vertex at a time. Shadows, lamps that are near and light from other
/// parts of the object err smoothly, so turns that vary slowly over the surface are taken out:
/// positions know those better.
///
/// @param views    with colours
/// @param sights   as AllSights gives them
/// @param smooth   rounds of Diffuse that make out what is slow
/// Source: Hernandez, Vogiatzis, Cipolla, PAMI 2008, and Nehab et al., SIGGRAPH 2005.
/// Departs: light of any distribution, by view.
ShadingNormals NormalsFromShading(const Mesh& mesh, const PointsX3& normals,
                                  const Neighbors& neighbors,
                                  const std::vector<PreparedView>& views,
                                  const std::vector<std::vector<float>>& sights, int smooth);

}  // namespace keypose::reconstruct
