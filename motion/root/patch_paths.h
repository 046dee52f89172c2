// Where patches of the target go, found on a small copy of it before the frames themselves are
// made.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/marks.h"
#include "motion/root/placed_poses.h"

namespace keypose::motion {

/// A surface decimated to at most 2500 vertices.
struct SmallCopy {
  PointsX3 points;
  FacesX3 faces;
};
SmallCopy CopyOf(const PointsX3& points, const FacesX3& faces);

/// Centres of patches in all frames, without corrections.
///
/// The frames are made with a copy of the target. Its marks lie on the faces nearest to the
/// target's. A patch moves rigidly with the copy's vertex nearest to its centre.
/// @param centres  P x 3, of the patches at rest
/// @return for each patch T x 3
std::vector<PointsX3> TrackPatches(const SmallCopy& copy, const PointsX3& target,
                                   const FacesX3& faces, const std::vector<Mark>& marks,
                                   const PointsX3& centres, const std::vector<MotionFrame>& frames,
                                   const RootPath& path);

}  // namespace keypose::motion
