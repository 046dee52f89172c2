// How table, camera and figure are set up: what a session must remember beside the photographs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace keypose::capture::shoot {

struct SetupState {
  double table_deg = 0;              ///< in [0, 360)
  std::optional<double> turning_to;  ///< set while the table turns
  std::string memory;                ///< TurntableDevice::Memory() while it turns
  std::string pose;                  ///< that is set up; "" for none yet
  int ring = 0, flip = 0;            ///< ring 0: not known
};

/// Nothing known if there is no such file, or it is damaged: then all is asked anew.
SetupState ReadSetupState(const std::filesystem::path& file);
/// @throws DiskError
void WriteSetupState(const std::filesystem::path& file, const SetupState& setup_state);

}  // namespace keypose::capture::shoot
