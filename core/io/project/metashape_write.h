// Cameras as Agisoft Metashape imports them (Import Cameras, Agisoft XML).
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// One chunk, its transform identity: its frame is the views' world, in local coordinates. Each
/// distinct camera is a sensor with an adjusted calibration: f is fy, b1 is fx - fy, cx and cy
/// count from the picture's middle, p1 and p2 are swapped. All digits are written.
/// @param labels  one for each view: Metashape's name of the photograph, its file's without ending
/// @param chunk   its label
/// @throws InputError  a label that is not UTF-8
std::string MetashapeText(const std::vector<View>& views, const std::vector<std::string>& labels,
                          const std::string& chunk);

}  // namespace keypose
