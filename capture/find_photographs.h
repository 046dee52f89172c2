// Finds and inspects photograph files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/pictures/photograph_checks.h"

namespace keypose::capture {

/// One placement of the figure on the table: a subfolder of the photographs, or all of them.
struct PhotographGroup {
  std::string name;  ///< "" for the folder itself
  std::filesystem::path folder;
  std::vector<std::filesystem::path> files;  ///< sorted
};

/// Files of a folder with names of JPEG, PNG, TIFF, HEIC or RAW, except background.*; of a RAW and
/// JPEG pair the JPEG. If the folder has none, its subfolders (except `masks` and `stacks`) are
/// groups, by name. If names begin with "lying" (any case), these are group "lying" and the others
/// "upright".
/// @throws InputError  no photographs, or some in the folder and some in subfolders
std::vector<PhotographGroup> ListPhotographs(const std::filesystem::path& folder);

/// Files among the photographs that are not photographs, in the folder, its groups and its other
/// subfolders; hidden files do not count.
std::vector<std::filesystem::path> IgnoredFiles(const std::filesystem::path& folder,
                                                const std::vector<PhotographGroup>& groups);

/// The clean plate beside the photographs (background.jpg, .png, .tif), or empty.
std::filesystem::path FindBackground(const std::filesystem::path& folder);

/// Reads headers and digests, in parallel.
/// @throws InputError  files that are no images (names all of them), or a photograph that exists as
/// HEIC and as JPEG
std::vector<Photograph> InspectPhotographs(const std::vector<PhotographGroup>& groups);

/// The pictures of a folder itself, without hidden ones, by name.
std::vector<std::filesystem::path> ImagesIn(const std::filesystem::path& folder);

/// Whether a file has the name of a mask of this photograph, by whatever program it was written:
/// NAME.*, NAME.EXT.*, with `mask` before or behind it, or with matte, alpha, cutout, out, seg or
/// silhouette behind. Case does not count.
bool IsMaskOf(const std::filesystem::path& file, const std::string& photograph_name);

/// The first mask in `folder` of a photograph, see IsMaskOf; empty if there is none.
std::filesystem::path FindMask(const std::filesystem::path& folder,
                               const std::string& photograph_name);

}  // namespace keypose::capture
