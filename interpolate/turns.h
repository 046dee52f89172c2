// Makes neighbouring faces turn the same way round.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "interpolate/face_maps.h"

namespace keypose::interpolation {

/// Adds whole turns (up to 4 either way) to faces' rotation vectors so that neighbours agree.
///
/// A tree over the faces of each connected part grows from the face that turns least, always by the edge whose two rotations differ least.
/// Each face takes, of its rotation vector plus whole turns about its own axis, the one nearest to its parent's. Where none is near (close
/// to whole turns a rotation has no usable axis) it copies its parent's, and what is left of its rotation goes to `remainder`. exp(turn)
/// exp(remainder) stays each face's rotation. Deterministic. Source: after Gao et al., as-consistent-as-possible axis-angle, TVCG 2019, by
/// a tree in place of a global solve.
void MakeTurnsConsistent(const FacesX3& faces, std::vector<FaceMap>& maps);

}  // namespace keypose::interpolation
