// Reads and writes points.json: points of known place, clicked in the pictures of fixed cameras.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/known_points.h"

namespace keypose {

/// docs/file-formats.md has the fields. Places are converted to metres. Where a camera gives no
/// `size`, that of its picture is read.
/// @throws DiskError   cannot be opened
/// @throws InputError  malformed; a field that is missing, of the wrong kind or out of range; a
/// name twice; a click of a camera or point that is not listed, or outside of its picture; names
/// file and item
KnownPoints ReadKnownPoints(const std::filesystem::path& path);

/// Places in metres.
std::string KnownPointsText(const KnownPoints& points);

}  // namespace keypose
