// The cameras of a shot: those of a calibration, matched to the films.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/project/rig_calibration.h"
#include "core/stage/stage.h"
#include "core/values/camera.h"
#include "views/shot/shot_camera.h"

namespace keypose {

/// The view of each camera of a shot, in its order and with its name; in the calibration's unit.
/// @param cameras  names of the shot's cameras
/// @param stage    its name, for messages
/// @throws InputError  a camera that the calibration does not have; names those that it has
std::vector<View> MatchedViews(const RigCalibration& rig, const std::vector<std::string>& cameras,
                               const std::string& stage);

/// Takes folders of pictures out of a shot that are no camera of the calibration and have far fewer
/// pictures than its films: people keep boards and notes beside films.
/// @return the names of what was taken out
std::vector<std::string> TakeOutUncalibrated(const RigCalibration& rig,
                                             std::vector<ShotCamera>& cameras);

/// The same for a stage, with a warning; and one where films and cameras are matched by nothing but
/// their order.
void LeaveOutUncalibrated(StageContext& stage, const RigCalibration& rig,
                          std::vector<ShotCamera>& cameras);

/// The world's axis nearest to the direction that is up in most pictures; unit.
Eigen::Vector3d UpOfCameras(const std::vector<View>& views);

/// "auto": UpOfCameras; else the axis of that name: x, y, z, -x, -y, -z.
Eigen::Vector3d UpOf(const std::string& name, const std::vector<View>& views);

/// "cam1, cam2"
std::string Listed(const std::vector<std::string>& names);

}  // namespace keypose
