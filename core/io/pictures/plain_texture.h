// Textures without what programs read in different ways.
#pragma once

#include <string>

namespace keypose {

/// A texture file whose pixels are what its stored RGB are, to every reader. Coordinates of meshes
/// address stored pixels: EXIF, which may turn the picture, is taken out. So is alpha, which
/// readers may multiply the colours by, and which hides nothing where a material is opaque.
/// Sources: glTF 2.0, sections 3.8.2 (orientation, profiles) and 3.9.2 (alpha).
/// @param bytes         of a PNG or JPEG; of any other kind they stay as they are
/// @param name          for messages
/// @param with_profile  keeps the colour profile; glTF says that it must be ignored
/// @return  the same bytes where there is nothing to take out; without alpha a PNG of 8 bits
/// @throws InputError  it has alpha and cannot be decoded
std::string PlainTexture(std::string bytes, const std::string& name, bool with_profile);

}  // namespace keypose
