// A calibration of fixed cameras, and what its readers share: rotations, sizes and lenses that are
// checked.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// Cameras in one world. What is up, and where the origin lies, is the file's choice.
struct RigCalibration {
  std::vector<View> views;  ///< in the file's order; the name is the camera's
  std::string format;       ///< "OpenCV YAML", "COLMAP model", "Qualisys", "matrices"
  /// length of the world's unit [m]; 0 where the format does not say
  double metres_per_unit = 0;
  /// the world's direction that points up, where the format fixes it (Qualisys: z)
  std::optional<Eigen::Vector3d> up;
  std::vector<std::string> notes;  ///< what was assumed or left out, for the user
};

/// A rotation that is one to 1e-2, made exact.
/// @param where  file and camera, for the message
/// @throws InputError  it is none
Eigen::Quaterniond ExactRotation(const Eigen::Matrix3d& r, const std::string& where);

/// The rotation of 9 numbers, row by row, or of 3 (Rodrigues), as they are.
/// @throws InputError  another number of them
Eigen::Matrix3d RotationOf(const std::vector<double>& numbers, const std::string& where);

/// @throws InputError  a lens that no camera has, or a place that is not finite
void RequireUsable(const View& view, const std::string& where);

/// A picture's width or height, rounded; a number beyond all pictures stays beyond them.
int SideOf(double pixels);

/// A matrix K that is none, such as one stored column by column, would give a wrong lens.
/// @param k  nine numbers, row by row
/// @throws InputError  not fx, skew, cx; 0, fy, cy; 0, 0, 1
void RequireUpperTriangle(const double* k, const std::string& where);

}  // namespace keypose
