// Places cameras by points of known place that somebody clicked in their pictures.
#pragma once

#include <optional>
#include <vector>

#include "core/values/camera.h"
#include "core/values/known_points.h"

namespace keypose::capture {

struct ClickError {
  int point = 0;
  Eigen::Vector2d expected;  ///< where the placed camera sees the point
  double px = 0;             ///< between there and the click
  bool wrong = false;        ///< left out: it does not agree with the others
};

struct PlacedCamera {
  View view;
  std::vector<ClickError> clicks;  ///< in the order of the camera's
  double rms_px = 0;               ///< of the clicks that are not wrong
  double place_error_m = 0;        ///< standard deviation of the centre, from the clicks' errors
  double focal_error = 0;          ///< relative standard deviation of an estimated focal length
};

/// The camera's place, and without a lens its focal length: one focal length, the principal point
/// in the picture's middle, no distortion.
///
/// Every three clicks give up to four places (with a lens; else for a series of focal lengths). The
/// one that most clicks agree with is adjusted to all of them but the wrong ones, whose error is
/// more than 0.6 % of the picture's longer side and more than four times that of the others.
/// @throws InputError  fewer than four clicks (six without a lens), three points at one place or on
/// a line, clicks that agree with no place, a focal length that the points do not tell; names the
/// camera, its errors and the cure
/// Source: Ke & Roumeliotis, CVPR 2017 (P3P, as in OpenCV); Fischler & Bolles, CACM 1981.
/// @param lens  for pictures of the clicked size; none: estimated with the place
PlacedCamera PlaceCamera(const ClickedPicture& camera, const std::optional<Camera>& lens,
                         const std::vector<KnownPoint>& points);

/// Where the cameras see a point, and how far that is from where it was said to be.
struct SeenPoint {
  int point = 0;
  Eigen::Vector3d seen;  ///< in world [m]
  double apart_m = 0;    ///< from its known place
  int cameras = 0;
};

/// Points that two or more cameras agree on, from the clicks that are not wrong.
std::vector<SeenPoint> SeePoints(const std::vector<ClickedPicture>& cameras,
                                 const std::vector<PlacedCamera>& placed,
                                 const std::vector<KnownPoint>& points);

}  // namespace keypose::capture
