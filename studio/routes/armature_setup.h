// The set-up of a puppet's session, as pages send it and the studio keeps it.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/runs/armature_control.h"
#include "studio/runs/calibrate_control.h"

namespace keypose::studio {

/// A take's name. @throws UsageError  it cannot be one
std::string TakeName(const nlohmann::json& name);

/// A file that a page names from the project's folder.
/// @throws NotFound  it is not there, or leads out of the project
std::filesystem::path FileOfProject(const std::filesystem::path& project, const std::string& name,
                                    bool may_be_folder);

double WithinRange(const nlohmann::json& value, double least, double most, const char* what);

/// @throws UsageError, NotFound  a field is wrong, a file is not there, or one leads out of the
/// project
ArmatureSetup ArmatureSetupFrom(const nlohmann::json& body, const std::filesystem::path& project);
/// What the page asks for of a calibration. @throws UsageError, NotFound  as above
CalibrateSetup CalibrateSetupFrom(const nlohmann::json& body, const std::filesystem::path& project);
nlohmann::json ArmatureSetupJson(const ArmatureSetup& setup);

/// The set-up of the last session in this project; null without one.
std::filesystem::path LastSetupFile(const std::filesystem::path& project);

/// @throws UsageError, NotFound  it cannot be a take's name, or there are no curves of it
void RequireTake(const std::filesystem::path& project, const std::string& take);

/// With which files a take was recorded: as it was kept, or else as they are found (take_puppet.h),
/// which is kept.
/// @throws UsageError, NotFound  no such take, no puppet fits it, or its files are gone
ArmatureSetup SetupOfTake(const std::filesystem::path& project, const std::string& take);
/// The same, before its files are looked for. @throws UsageError, NotFound
nlohmann::json SetupJsonOfTake(const std::filesystem::path& project, const std::string& take);
void KeepSetupOfTake(const std::filesystem::path& project, const ArmatureSetup& setup);

}  // namespace keypose::studio
