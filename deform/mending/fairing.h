// Smooth surfaces over a part of a mesh, which meet the rest of it without a crease.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "deform/mending/brushed.h"

namespace keypose {

/// Where the vertices go on a thin plate that the rest of the mesh holds by place and slope: the
/// minimum of the squared Laplacian, by cotangents of the shape that it has itself.
/// @param free  vertices, ascending; some of the mesh must not be free
/// @param points  V x 3
/// @return free x 3
/// @throws InputError  no vertex next to the free ones stays
PointsX3 ThinPlate(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
                   const std::vector<int>& free);

/// Where the vertices go when waves shorter than about 1.6 `width` fade: the minimum of the squared
/// distance to where they are plus (width / 4)^4 times the squared Laplacian. The rest stays, and
/// holds by place and slope.
PointsX3 Faded(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
               const std::vector<int>& free, double width);

}  // namespace keypose
