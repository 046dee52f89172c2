// Landmarks of the page: read, checked, saved, imported, exported.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/io/project/landmarks_io.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// {name, face, barycentric}, as the page has them.
nlohmann::json PickJson(const Landmark& pick);
/// @throws UsageError  it has no name, or is not on the mesh
Landmark PickFrom(const nlohmann::json& value, const Mesh& mesh);

/// Where the pipeline takes a pose's picks from once they are saved: the file that pipeline.yaml
/// names, else landmarks/POSE.json. @throws UsageError  outside of the project
std::filesystem::path PicksFile(Snapshot& snapshot, const std::string& pose);

/// The file with a pose's picks as the pipeline takes them: PicksFile or, where pipeline.yaml names
/// none, MeshLab's landmarks/POSE.pp; empty if there is none. @throws UsageError  as PicksFile
std::filesystem::path ExistingPicks(Snapshot& snapshot, const std::string& pose);

/// Removes PicksFile; pipeline.yaml then does not name it any more.
/// @throws UsageError  pipeline.yaml cannot be changed
void RemovePicks(Snapshot& snapshot, const std::string& pose);

/// A pose's picks on the mesh that they are picked on, with what is wrong with them.
/// @throws UsageError  no such pose, or its mesh is not made yet
nlohmann::json PicksJson(Snapshot& snapshot, const std::string& pose);

/// Writes PicksFile; without picks, removes it.
/// @param body  {"picks": [{name, face, barycentric}], "revision": ...}
/// @throws ChangedMeanwhile, UsageError
/// @throws InputError  the file cannot be read, and what is in it would be lost
void SavePicks(Snapshot& snapshot, const std::string& pose, const nlohmann::json& body);

/// Replaces a pose's picks by those of a file: MeshLab's .pp, Wrap's points, or our JSON.
/// @param name  the file's name, for messages and its kind
void ImportPicks(Snapshot& snapshot, const std::string& pose, const std::string& name,
                 const std::string& text);

/// @param format  "json", "pp" or "wrap"
std::string ExportPicks(Snapshot& snapshot, const std::string& pose, const std::string& format);

/// The template's picks that can be read, and its mesh; none where one of the two is missing.
std::vector<Landmark> TemplatePicks(Snapshot& snapshot, Mesh* mesh);

/// The last registration's advice on where one more landmark helps most.
nlohmann::json AdviceJson(Snapshot& snapshot, const std::string& pose);

/// How far the registered template's landmarks are from the pose's of the same name, over the
/// pose's diagonal: {"pairs": [{"name", "distance"}]}, none before the first registration.
/// @throws UsageError  no such pose
nlohmann::json PairFitJson(Snapshot& snapshot, const std::string& pose);

/// Pairs from the file that `keypose landmarks suggest` writes.
nlohmann::json SuggestionsJson(Snapshot& snapshot, const std::string& pose,
                               const std::filesystem::path& suggested);

/// A factor for each of the template's vertices, or null when nothing is painted.
nlohmann::json StiffnessJson(Snapshot& snapshot);
/// Writes stiffness.json, which `register` takes; without values, removes it.
/// @param body  {"values": [...] or null, "revision": ...}
void SaveStiffness(Snapshot& snapshot, const nlohmann::json& body);
/// Vertex lists of the timeline's regions, by name.
nlohmann::json RegionsJson(Snapshot& snapshot);
void SaveRegions(Snapshot& snapshot, const nlohmann::json& body);

}  // namespace keypose::studio
