// A folder that a tethering program, a phone's sync or a person fills with photographs.
#pragma once

#include <filesystem>
#include <memory>

#include "capture/shoot/devices/camera_device.h"

namespace keypose::capture::shoot {

struct FolderTimes {
  double still_s = 1.0;  ///< a file that has not grown for so long is complete
  double pair_s = 2.0;   ///< for the second file of a RAW and JPEG pair
};

/// Each file that is new since Connect, oldest first. Files of one stem (IMG_1.CR2, IMG_1.JPG) are
/// one photograph. They are copied, never moved.
std::unique_ptr<CameraDevice> MakeFolderCamera(const std::filesystem::path& folder,
                                               const FolderTimes& times = {});

}  // namespace keypose::capture::shoot
