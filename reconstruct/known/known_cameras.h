// Assigns cameras that are known beforehand to the photographs of a set.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose::reconstruct {

/// Known cameras under the names of their photographs: of the same name, else of the same stem
/// ("r_001" for "r_001.png"), with intrinsics for the photographs' size. Folders in a view's name
/// are those that capture puts before a photograph's: "left/1.jpg" is the camera of "left_1.jpg",
/// and where there is none, of "1.jpg".
///
/// @param known   names may lack an extension; sizes and principal points of 0 are filled in from
/// the photograph; a negative focal length is in units of the photograph's width
/// @param photographs  of the set, sorted by name
/// @param sizes        for each its width and height
/// @return sorted by name; photographs without a known camera are left out
/// @throws InputError  cameras whose names are not among the photographs (lists them), two for one
/// photograph, another aspect ratio
std::vector<View> MatchKnownPoses(const std::vector<View>& known,
                                  const std::vector<std::string>& photographs,
                                  const std::vector<Camera>& sizes);

}  // namespace keypose::reconstruct
