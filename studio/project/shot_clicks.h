// Clicks that help to find the camera of a filmed shot: pixels of its frames and places on the
// mesh; and how the camera of one frame is asked for by its clicks alone.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// "clicks", "revision" of their file, "problem" in words
nlohmann::json ClicksJson(Snapshot& snapshot);

/// Writes the clicks to the file that pipeline.yaml names (clicks.json, which then stands there, if
/// none). Without clicks, the file and its name in pipeline.yaml go.
/// @param body  {"clicks": [...], "revision": of the file}
/// @throws UsageError  a click without pixel or place; a file outside of the project
/// @throws ChangedMeanwhile
void SaveClicks(Snapshot& snapshot, const nlohmann::json& body);

/// Files of `keypose locate --quick` on one frame.
struct QuickFiles {
  std::filesystem::path clicks, shot, picture;
};
/// @param number  of the answer: another one has other files, so that one can still be read
QuickFiles QuickFilesOf(const std::filesystem::path& project, int number);

/// The flags of `keypose locate --quick` for one frame. Writes its clicks.
/// @throws UsageError  fewer than four clicks in the frame, no pose, or a pose without mesh
std::vector<std::string> QuickLocateFlags(Snapshot& snapshot, int frame, const QuickFiles& files);

/// What that has found: "focal_px", "focal", and with mattes "contour_px" and "iou" (else null).
nlohmann::json QuicklyLocatedJson(const QuickFiles& files);

}  // namespace keypose::studio
