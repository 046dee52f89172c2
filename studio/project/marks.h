// Marks of a performance: pairs of places on the tracked body and on the scan that shall move as
// it.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// The two meshes of a mark, as the page names them.
enum class MarkSide { kBody, kScan };
/// "body", "scan"
std::optional<MarkSide> MarkSideNamed(const std::string& name);

/// The file that `transfer` takes: the one that pipeline.yaml names, else marks.json.
/// @throws UsageError  it is outside of the project
std::filesystem::path MarksFile(Snapshot& snapshot);

/// The tracked body upright, of the first shot that has one; or the scan that pipeline.yaml names.
/// @return none: there is no such mesh by now @throws UsageError  the scan is outside of the
/// project
std::optional<std::filesystem::path> MarkedMesh(Snapshot& snapshot, MarkSide side);
/// The scan's texture; none where there is none, or no mesh whose texture coordinates it needs.
std::optional<std::filesystem::path> ScanTexture(Snapshot& snapshot);

/// - revision, problem  of the file; why it cannot be read, or ""
/// - pairs  {name, source, target, confirmed, confidence} as PickJson
/// - body, scan  {there, version, missing}: why there is no mesh yet; scan also {textured}
/// @throws UsageError  the project is no performance
nlohmann::json MarksJson(Snapshot& snapshot);

/// Writes MarksFile; without pairs, removes it.
/// @param body  {"pairs": [{source, target}], "revision": ...}
/// @throws ChangedMeanwhile, UsageError
/// @throws InputError  the file cannot be read, and what is in it would be lost
void SaveMarks(Snapshot& snapshot, const nlohmann::json& body);

/// {name, source, target, confidence} of the pairs in a file that no person has confirmed.
nlohmann::json SuggestedMarksJson(Snapshot& snapshot, const std::filesystem::path& file);

/// Names the scan, and its texture or none, in pipeline.yaml: files of the project.
/// @throws UsageError  they are not there, or cannot be read
void UseScan(Snapshot& snapshot, const std::string& scan, const std::string& texture);

}  // namespace keypose::studio
