// Reads the cameras that Agisoft Metashape exports (Export Cameras, Agisoft XML).
#pragma once

#include <string>
#include <vector>

#include "core/values/lens.h"

namespace keypose {

/// Whether the text is such a file: an XML document with a chunk.
bool IsMetashape(const std::string& text);

/// The cameras of the document's one chunk. A sensor's adjusted calibration counts before the
/// initial one: f, cx, cy, b1, b2, k1 to k4, p1 to p4, of the types frame, fisheye and
/// equidistant_fisheye (theta), equisolid_fisheye (2 sin(theta / 2)). Cameras without a place, and
/// those that are switched off, are left out. Places are in the chunk's own frame, as cameras hold
/// them; where several components have cameras, all are moved into that of the first by the
/// components' transforms. Source: Metashape Professional's manual 2.1, appendix D; XML of
/// version 1.3 to 2.1.
/// @param file  its name, for messages
/// @throws InputError  damaged, several chunks, no camera with a place, components that nothing
/// joins, a photograph that its EXIF turns, another type (spherical, cylindrical, rpc) or number:
/// names camera or sensor, and the type
std::vector<LensView> ParseMetashape(const std::string& text, const std::string& file);

}  // namespace keypose
