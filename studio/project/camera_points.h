// Points of known place, clicked in a still picture of each camera of a performance, by which
// `keypose calibrate` finds the cameras. All of it needs no plan: a performance has none before its
// cameras are calibrated.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "views/shot/shot_camera.h"

namespace keypose::studio {

/// Names within the project's folder.
inline constexpr const char* kPointsFile = "points.json";
inline constexpr const char* kCalibrationFile = "calibration.yml";

/// - revision  of points.json
/// - problem   what is wrong with it, or with the project's films; or ""
/// - points    {name, place} [m]; clicks {camera, point, pixel}
/// - cameras   {name, width, height, frames, still, problem}: `frames` of its film where that is
///             shown, 0 where `still` names a picture
/// - offers    what the lenses may come from, below the project
/// - shots     {name, calibration, ours}: the file that its steps take, "" for none
/// - result    of the last calibration (CalibrationResultJson), or null
/// @throws UsageError  the project is no performance
nlohmann::json CameraPointsJson(const std::filesystem::path& project);

/// Writes points.json. Cameras that it has stay in it; those with clicks are added.
/// @param body  {revision, points, clicks}
/// @throws UsageError  a point without a name
/// @throws InputError  as ReadKnownPoints: what is wrong with them, or with the file that is there
/// @throws ChangedMeanwhile
void SaveCameraPoints(const std::filesystem::path& project, const nlohmann::json& body);

/// What is shown of a camera: a film, or one picture as a film of one frame.
/// @throws NotFound  no such camera, or it has no picture
FrameSource StillOf(const std::filesystem::path& project, const std::string& camera);

/// The flags of `keypose calibrate`.
/// @param lenses     one of the offers, or "": lenses from the points
/// @param square_mm  of a board in these pictures
/// @throws UsageError  not one of them
std::vector<std::string> CalibrateFlags(const std::filesystem::path& project,
                                        const std::string& lenses, double square_mm);

/// Puts what these flags have made into the project; another calibration of that name that is there
/// becomes calibration.before.yml.
/// @param revision  of the points that it was made with
void TakeCalibration(const std::filesystem::path& project, const std::string& revision);

/// Lets a shot take calibration.yml.
/// @throws UsageError  no such shot, or there is no calibration.yml
void UseCalibration(const std::filesystem::path& project, const std::string& shot);

}  // namespace keypose::studio
