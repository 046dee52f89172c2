// The cameras of a shot: those of a calibration, matched to the films.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/io/rig_calibration.h"

namespace keypose {

/// The view of each camera of a shot, in its order and with its name; in the calibration's unit.
/// @param cameras  names of the shot's cameras
/// @param stage    its name, for messages
/// @throws InputError  a camera that the calibration does not have; names those that it has
std::vector<View> MatchedViews(const RigCalibration& rig, const std::vector<std::string>& cameras,
                               const std::string& stage);

/// The world's axis nearest to the direction that is up in most pictures; unit.
Eigen::Vector3d UpOfCameras(const std::vector<View>& views);

/// "auto": UpOfCameras; else the axis of that name: x, y, z, -x, -y, -z.
Eigen::Vector3d UpOf(const std::string& name, const std::vector<View>& views);

/// "cam1, cam2"
std::string Listed(const std::vector<std::string>& names);

}  // namespace keypose
