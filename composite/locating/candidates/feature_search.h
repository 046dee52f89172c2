// Where a textured mesh is seen from, by features of the picture.
#pragma once

#include <optional>
#include <vector>

#include "composite/locating/lens/normal_equations.h"
#include "core/values/image.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"
#include "views/placement/surface_features.h"

namespace keypose::composite {

/// A place of the mesh that a picture shows.
struct Sighting {
  SurfacePoint point;
  Eigen::Vector2d pixel;  ///< centres at .5
};

struct FeatureCandidate {
  Placement placement;
  std::vector<Sighting> inliers;
  double rms_px = 0;
};

/// The place that agrees with most matches, over all focal lengths that are tried; none when too
/// few agree.
///
/// @param points   of the mesh, in the picture's pose
/// @param picture  RGB, of the camera's size
/// @param matte    1 channel; empty: the whole picture
/// @param focal_factors  on the camera's focal length
/// Same bits for any thread count.
std::optional<FeatureCandidate> PlaceByFeatures(const SurfaceFeatures& features,
                                                const PointsX3& points, const Image8& picture,
                                                const Image8& matte, const Camera& camera,
                                                const std::vector<double>& focal_factors);

/// Least squares on sightings, with a weight that falls beyond `within_px`.
/// @param center, radius  of the mesh, as for NormalEquations
Placement RefinedBySightings(const Placement& start, const PointsX3& points,
                             const std::vector<Sighting>& sightings, double within_px,
                             const Eigen::Vector3d& center, double radius, bool focal, int rounds);

}  // namespace keypose::composite
