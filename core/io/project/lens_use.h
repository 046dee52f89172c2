// What all readers of cameras do with a lens: check it, and make the camera of it that Keypose
// works with.
#pragma once

#include <string>

#include "core/values/lens.h"

namespace keypose {

/// @param where  file and camera, for the message
/// @throws InputError  a parameter that is not finite or not possible for a lens; no pixels, or
/// more than kMostPixels
void RequireUsableCamera(const Camera& camera, const std::string& where);

/// @param where  file and camera, for the message
/// @throws InputError  a number that is not finite or not possible for a lens; pictures without
/// pixels, or of more than kMostPixels (width and height may both be 0: not known)
void RequireUsableLens(const Lens& lens, const std::string& where);

/// The camera that maps as the lens does, to kSameLens_px.
/// @throws InputError  as RequireUsableLens; no camera does: names the model and how to get
/// pictures without distortion
Camera UsableCamera(const Lens& lens, const std::string& where);

/// Refuses a model that no Lens can be, such as a panorama's, by its name.
/// @throws InputError  always
[[noreturn]] void RefuseModel(const std::string& model, const std::string& where);

}  // namespace keypose
