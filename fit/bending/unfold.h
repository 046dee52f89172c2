// Faces that were flipped by contradicting constraints, turned back.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::fit {

/// Moves the vertices of flipped faces to where their neighbours, as rigid as possible, expect
/// them, until no face is flipped or nothing helps. A face is flipped when its normal opposes its
/// rest normal under the mean of its vertices' maps.
///
/// @param rest    V x 3
/// @param maps    V, rotations from rest to `points`
/// @param points  V x 3, changed
/// @return how many vertices were moved
int Unfold(const PointsX3& rest, const FacesX3& faces, const std::vector<Eigen::Matrix3d>& maps,
           PointsX3& points);

/// How many faces are flipped, as of Unfold.
int FlippedFaces(const PointsX3& rest, const FacesX3& faces,
                 const std::vector<Eigen::Matrix3d>& maps, const PointsX3& points);

}  // namespace keypose::fit
