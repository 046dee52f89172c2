// A folder that a tethering program, a phone's sync or a person fills with photographs.
#pragma once

#include <filesystem>
#include <memory>

#include "capture/shoot/devices/camera_device.h"

namespace keypose::capture::shoot {

struct FolderTimes {
  double still_s = 1.5;  ///< a file that has not changed for so long is complete
  double pair_s = 2.0;   ///< for the second file of a RAW and JPEG pair; more once it came later
  double unfinished_s = 10;  ///< a picture that ends too early is taken for damaged after so long
};

/// Each file that is new since Connect, or has other bytes under its old name, oldest first. Files
/// of one stem (IMG_1.CR2, IMG_1.JPG) are one photograph; one that comes after its photograph was
/// taken is left in the folder. They are copied, never moved.
std::unique_ptr<CameraDevice> MakeFolderCamera(const std::filesystem::path& folder,
                                               const FolderTimes& times = {});

}  // namespace keypose::capture::shoot
