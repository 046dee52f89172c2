// Reads what an MP4 or QuickTime file says of its film, without decoding it.
#pragma once

#include <filesystem>
#include <string>

namespace keypose {

struct MovieHeader {
  int frames = 0;      ///< that are shown: without those before and after an edit list's parts
  double fps = 0;      ///< while no picture is missing: of a film of constant rate its mean
  int last_frame = 0;  ///< frames of this rate from the first picture to the last one
  int width = 0, height = 0;  ///< as a player shows it: of a film that is turned by its header too
  std::string codec;          ///< four letters, such as avc1 (H.264), hvc1, ap4h (ProRes)
};

/// Whether the file begins as MP4 and QuickTime files do. False when it cannot be read.
bool IsMovie(const std::filesystem::path& path);

/// The file's boxes are walked: none is cut off, and there is an index.
/// @throws DiskError   cannot be opened
/// @throws InputError  cut off, damaged, or no index; names the file and what to do
void RequireWholeMovie(const std::filesystem::path& path);

/// Of the first video track. Source: ISO/IEC 14496-12; QuickTime File Format.
/// @throws DiskError   cannot be opened
/// @throws InputError  cut off, no index (a recording that was not ended), no video track, index in
/// pieces (fragmented), or damaged; names the file and what to do
MovieHeader ReadMovieHeader(const std::filesystem::path& path);

}  // namespace keypose
