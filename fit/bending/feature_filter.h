// Which feature matches can be true together, whatever the pose.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "views/placement/surface_features.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// Matches of one view that agree with their neighbours: two points of a surface that bends but
/// does not stretch are never farther apart in a picture than on the surface.
///
/// @param rest      V x 3 of the surface, in the unit of the camera's distance
/// @param distance  of the camera from the surface
/// @return indices of the kept matches, ascending
std::vector<int> ConsistentMatches(const PointsX3& rest, const std::vector<FeatureMatch>& matches,
                                   const Pinhole& camera, double distance);

/// Matches whose distance in the picture from where the mesh shows their place now is like that of
/// the matches around them.
///
/// @param shown  for each match, the pixel at which the mesh shows its place
/// @return indices of the kept matches, ascending
std::vector<int> SmoothMatches(const PointsX3& rest, const std::vector<FeatureMatch>& matches,
                               const std::vector<Eigen::Vector2d>& shown);

/// Matches near where the mesh shows their places now, that pass both tests.
///
/// @param now  V x 3, where the surface is now
std::vector<FeatureMatch> NearbyMatches(const PointsX3& rest, const PointsX3& now,
                                        const std::vector<FeatureMatch>& matches,
                                        const Pinhole& camera, const Rigid3& camera_from_world);

}  // namespace keypose::fit
