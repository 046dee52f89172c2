// What masks were painted over. The studio notes it beside them, in painted.json, so that a mask is
// not taken for a photograph that was shot again under the same name.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace keypose {

inline constexpr const char* kPaintedNotes = "painted.json";

/// SHA-256 of two files: the mask as it was saved, and the photograph that it was painted over.
struct PaintedMask {
  std::string mask, photograph;
  bool operator==(const PaintedMask&) const = default;
};
/// By the mask's file name.
using PaintedMasks = std::map<std::string, PaintedMask>;

/// The notes of a folder of masks; none where no page has painted.
/// @throws InputError  they cannot be read
PaintedMasks ReadPaintedMasks(const std::filesystem::path& folder);
/// Without masks, the file goes.
/// @throws DiskError
void WritePaintedMasks(const std::filesystem::path& folder, const PaintedMasks& masks);

/// Whether a mask is known to be of another photograph. A mask that another program changed since
/// is not known, and counts for whatever bears its name.
/// @param mask, photograph  as the two files are now
bool IsOfAnother(const PaintedMasks& masks, const std::string& name, const PaintedMask& now);

}  // namespace keypose
