// Which photographs see which vertex of a surface, and which of them are best to compare.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

constexpr int kBestViews = 8;

/// The views that a vertex is compared in, best first.
struct VertexViews {
  std::array<std::int16_t, kBestViews> view;
  std::int16_t count = 0;
  float footprint = 0;  ///< world length of a pixel of level 0 in the view that sees it largest; 0
                        ///< when none sees it
};

/// For each view how well it sees each vertex: pixels along a unit of length, times the facing's
/// cosine; 0 when it does not. A view sees a vertex when its normal faces the camera within 72
/// degrees, its picture lies within the mask, and nothing of the surface lies before it (a depth
/// buffer at half resolution).
///
/// @param normals  V x 3 unit
/// Cost: the faces once a view.
/// Same bits for any thread count.
std::vector<std::vector<float>> AllSights(const Mesh& mesh, const PointsX3& normals,
                                          const std::vector<PreparedView>& views);

/// Of the views that see a vertex the best are taken, squarely and closely looking ones first, none
/// much nearer than 12 degrees to one already taken: neighbours on a dense ring tell nothing of
/// depth.
///
/// @param sights  as AllSights gives them
/// Cost: views times kBestViews a vertex.
/// Same bits for any thread count.
std::vector<VertexViews> ChooseViews(const PointsX3& points, const std::vector<PreparedView>& views,
                                     const std::vector<std::vector<float>>& sights);

}  // namespace keypose::reconstruct
