// Calibrations of rigs as Kalibr, MC-Calib, EasyMocap and anipose write them.
#pragma once

#include <string>

#include "core/io/project/rig_parts.h"

namespace keypose {

// @param text  of the file
// @param file  its name, for messages
// @throws InputError  what is missing or not known, a lens that no Camera maps as: names file and
// camera

/// Kalibr's camchain: cam0 and on, each with `intrinsics`, and T_cn_cnm1 from the one before. The
/// world is the first camera, in metres. Camera models pinhole, omni, eucm, ds; distortion radtan,
/// equi(distant), fov, none. Source: Kalibr's wiki, "yaml formats", "supported models".
bool IsKalibr(const std::string& text);
void AddKalibr(const std::string& text, const std::string& file, RigCalibration* rig);

/// MC-Calib's calibrated_cameras_data.yml: camera_0 and on, with `camera_pose_matrix` (world from
/// camera), `distortion_type` 0 (OpenCV's five) or 1 (fisheye). One camera group, the board's unit.
/// Source: saveCamerasParams in its McCalib.cpp, 2024.
bool IsMcCalib(const std::string& text);
void AddMcCalib(const std::string& text, const std::string& file, RigCalibration* rig);

/// EasyMocap's intri.yml (names; K_NAME, dist_NAME or D_NAME, H_NAME, W_NAME) and extri.yml
/// (Rot_NAME, R_NAME, T_NAME). Source: camera_utils.py, 2023.
void AddEasyMocap(const std::string& intri, const std::string& extri, const std::string& file,
                  RigCalibration* rig);

/// The calibration.toml of anipose, FreeMoCap and Pose2Sim: a table for each camera with name,
/// size, matrix, distortions, rotation (Rodrigues), translation, fisheye. The unit is the board's,
/// which the file does not say. Source: aniposelib's cameras.py, 0.6.
void AddAnipose(const std::string& text, const std::string& file, RigCalibration* rig);

}  // namespace keypose
