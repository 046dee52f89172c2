// `keypose cameras`: the cameras of a pose, with photographs and masks, for other programs.
#pragma once

#include <string>

#include "core/values/errors.h"
#include "core/values/progress.h"

namespace keypose::pipeline {

struct CamerasOptions {
  std::string folder;      ///< the project; empty: as FindProject
  std::string pose;        ///< empty: the template
  std::string format;      ///< one of CameraFormatNames
  std::string output;      ///< empty: PROJECT_POSE_FORMAT in the working folder
  bool overwrite = false;  ///< a folder with other things is replaced
};

/// Writes the folder (camera_folder.h) and prints what is in it. The folder appears when it is
/// complete. Cameras that a run would make anew are written as they were last made, and that is
/// said.
/// @throws UsageError  no such pose, or a performance, whose cameras are the user's own
/// @throws InputError  the pose has no cameras yet, or its masks are not of these cameras
/// @throws DiskError   the output has other things in it, or may not be replaced
/// @throws Cancelled   `progress` says so; nothing is left
ExitCode CamerasCommand(const CamerasOptions& options, Progress* progress);

}  // namespace keypose::pipeline
