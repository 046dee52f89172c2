// What is kept of an armature's sensors while no program reads them (docs/file-formats.md).
#pragma once

#include <string>
#include <vector>

#include "armature/controller/joint_tracker.h"

namespace keypose::armature {

struct Calibration {
  int boot = -1;                     ///< of the controller whose counters these are; -1: none yet
  std::vector<SensorState> sensors;  ///< for each of the armature's joints
};

std::string CalibrationText(const Armature& armature, const Calibration& calibration);

/// @param file  its name, for messages
/// @throws InputError  malformed, or a joint of the armature is missing in it or has another sensor
/// there: it was made for another description
Calibration ParseCalibration(const std::string& text, const std::string& file,
                             const Armature& armature);

/// What still fits of one that was made for another description: for a joint that has another
/// sensor now, or is new, a fresh state.
/// @param fresh  gets the names of these joints
/// @throws InputError  malformed
Calibration FittingCalibration(const std::string& text, const std::string& file,
                               const Armature& armature, std::vector<std::string>* fresh);

}  // namespace keypose::armature
