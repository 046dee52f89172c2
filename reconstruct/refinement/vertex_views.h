// Which photographs see each vertex of a surface, and which of them are best to compare.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

constexpr int kBestViews = 8;

/// The views that a vertex is compared in, best first.
struct VertexViews {
  std::array<std::int16_t, kBestViews> view;
  std::int16_t count = 0;
  float footprint = 0;  ///< size of a pixel of level 0 in the view that sees it largest, in world
                        ///< units; 0 when no view does
};

/// For each view and vertex: pixels per unit of length times the cosine to the viewing direction; 0
/// when the view does not see the vertex. A view sees a vertex when the normal faces the camera
/// within 72 degrees, the projection is in the mask, and no other surface occludes it (a depth
/// buffer at half resolution).
///
/// @param normals  V x 3 unit
/// Cost: one pass over the faces per view.
/// Same bits for any thread count.
std::vector<std::vector<float>> AllSights(const Mesh& mesh, const PointsX3& normals,
                                          const std::vector<PreparedView>& views);

/// The best of the views that see a vertex: frontal and close ones first, none much nearer than 12
/// degrees to one already taken, because neighbouring views of a dense ring do not determine depth.
///
/// @param sights  from AllSights
/// Cost: views times kBestViews per vertex.
/// Same bits for any thread count.
std::vector<VertexViews> ChooseViews(const PointsX3& points, const std::vector<PreparedView>& views,
                                     const std::vector<std::vector<float>>& sights);

}  // namespace keypose::reconstruct
