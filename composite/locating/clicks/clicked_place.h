// Where a mesh is seen from, by pairs of a pixel and a place on the mesh that a person clicked.
#pragma once

#include <string>
#include <vector>

#include "composite/locating/lens/normal_equations.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::composite {

struct Click {
  std::string name;       ///< for messages
  Eigen::Vector2d pixel;  ///< centres at .5
  SurfacePoint point;     ///< on the mesh
};

/// @param points  of the mesh, in the picture's pose
/// @param focal   also solve the focal length; needs 6 clicks
/// @throws InputError  fewer than 4 clicks; clicks on one line; clicks that do not agree, where the
/// message names the worst
/// Sources: SQPnP, Terzakis & Lourakis, ECCV 2020, as in OpenCV; then Levenberg-Marquardt.
Placement PlaceByClicks(const Camera& camera, const PointsX3& points,
                        const std::vector<Click>& clicks, bool focal);

/// Root mean square distance of the clicks from where the placement has them [px].
double ClickError(const Placement& at, const PointsX3& points, const std::vector<Click>& clicks);

}  // namespace keypose::composite
