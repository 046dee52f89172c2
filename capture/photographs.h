// Finds and inspects photograph files. Defined in photographs_stage.cpp, which may touch files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/checks.h"

namespace keypose::capture {

/// Files of a folder that are JPEG, PNG or TIFF by name, sorted; a file background.* is not among them.
/// @throws InputError  none there
std::vector<std::filesystem::path> ListPhotographs(const std::filesystem::path& folder);

/// The plate beside the photographs (background.jpg, .png, .tif), or empty.
std::filesystem::path FindBackground(const std::filesystem::path& folder);

/// Reads headers and digests, in parallel. @throws InputError  files that are no images; names all of them
std::vector<Photograph> InspectPhotographs(const std::vector<std::filesystem::path>& files);

/// The mask in `folder` that belongs to a photograph: STEM.*, NAME.EXT.* or STEM_mask.*; empty when there is none.
std::filesystem::path FindMask(const std::filesystem::path& folder, const std::string& photograph_name);

}  // namespace keypose::capture
