// Reads and writes the calibration of a set of fixed cameras, as several programs keep it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/project/rig_parts.h"
#include "core/values/camera.h"

namespace keypose {

/// Reads what the path holds, by content:
/// - OpenCV's YAML or JSON: a folder with a file for each camera (its name is the camera's), or one
///   file with a node for each. Nodes: camera_matrix, distortion_coefficients, distortion_model
///   (opencv_lens.h), image_width, image_height, rotation (3 x 3, or 3 numbers: Rodrigues) and
///   translation from world to camera; the names K, D, dist_coeffs, image_size, R, rvec, T, tvec
///   and others are known too; fisheye or fisheye_model: 1; `unit: mm` or `unit: m`.
/// - what programs make of these (rig_programs.h): Kalibr's camchain, MC-Calib's cameras,
/// EasyMocap's
///   folder of intri.yml and extri.yml, the calibration.toml of anipose, FreeMoCap and Pose2Sim.
/// - COLMAP, transforms.json, Metashape: as poses_io.h.
/// - Qualisys: the text that its calibration exports (XML; millimetres; bounds are inclusive; where
///   the camera filmed a window of its sensor, that window).
/// - matrices: for each camera its number, K (3 x 3), two radial coefficients, and camera from
///   world (3 x 4).
/// Width and height are 0 where the file does not give them. Each lens becomes the camera that maps
/// as it does, to kSameLens_px.
/// @throws InputError  of no such kind, damaged, no camera, a name twice, a rotation that is none,
/// a lens that no Camera maps as; names file, camera and lens model
RigCalibration ReadRigCalibration(const std::filesystem::path& path);

/// The same, where cameras in OpenCV YAML may have no place: lenses alone.
RigCalibration ReadLensCalibration(const std::filesystem::path& path);

/// One OpenCV YAML file with a node for each camera.
/// @param metres  places are in metres, and the file says so
std::string OpenCvYaml(const std::vector<View>& views, bool metres = true);

/// The same without places: what ReadLensCalibration reads.
std::string OpenCvLensYaml(const std::vector<View>& views);

/// The view of each camera, by name; else by the number in the name; else, when there are as many,
/// by order.
/// @param cameras  names, such as "cam03"
/// @return an index into `views` for each camera, -1: none
std::vector<int> MatchCameraNames(const std::vector<std::string>& cameras,
                                  const std::vector<View>& views);

/// Whether "cam2" comes before "cam10": numbers in names are compared as numbers.
bool NumberedBefore(const std::string& a, const std::string& b);

}  // namespace keypose
