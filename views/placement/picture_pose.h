// The pose of a camera from places of a known surface that its picture shows.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "views/placement/surface_features.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

struct PicturePose {
  bool found = false;
  Rigid3 camera_from_world;
  std::vector<int> inliers;  ///< indices of matches
  double rms_px = 0;
};

/// The pose that agrees with most matches. Matches on limbs that have moved are outliers.
///
/// @param points     V x 3 of the surface
/// @param within_px  an inlier's largest error
/// @param least      fewer inliers: not found
/// Deterministic (fixed seed).
/// Source: P3P of Ke & Roumeliotis, CVPR 2017, in RANSAC, as in OpenCV; then Levenberg-Marquardt.
PicturePose PlacePicture(const Pinhole& camera, const PointsX3& points,
                         const std::vector<FeatureMatch>& matches, double within_px, int least);

/// Improves a pose by robust least squares on matches.
/// @param within_px  distance at which a match has a quarter of its weight
Rigid3 RefinePose(const Pinhole& camera, const Rigid3& start, const PointsX3& positions,
                  const std::vector<Eigen::Vector2d>& pixels, const std::vector<double>& weights,
                  double within_px, int rounds = 10);

}  // namespace keypose
