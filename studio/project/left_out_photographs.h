// Photographs of a pose that are left out: the option `leave_out` of the step that reads them, in
// pipeline.yaml. They stay in their folder, and no step reads them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "studio/project/originals.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// What is left out of a pose, as pipeline.yaml names it; none where nothing reads photographs.
std::vector<std::string> LeftOutNames(const Snapshot& snapshot, const std::string& pose);

/// Those of a pose's photographs that are left out.
/// @param names  of photographs, as the page has them
std::vector<std::string> LeftOutAmong(Snapshot& snapshot, const std::string& pose,
                                      const std::vector<std::string>& names);

/// The text of pipeline.yaml with photographs left out, or taken back. As it is for no names.
/// @param text  of the project's pipeline.yaml as the snapshot has it, or with other values
/// @throws UsageError  no such photograph; nothing reads the pose's photographs
std::string WithLeftOut(Snapshot& snapshot, const std::string& text, const std::string& pose,
                        const std::vector<std::string>& names, bool out);

/// @param revision  of pipeline.yaml; empty: as it is now
void LeaveOut(Snapshot& snapshot, const std::string& pose, const std::vector<std::string>& names,
              bool out);

/// What runs again when a pose's photographs change: {"step", "follow": ids, "seconds": of the last
/// runs, "made": whether anything was made yet}.
nlohmann::json AgainJson(Snapshot& snapshot, const std::string& pose);
/// The same of a step and those after it; null: nothing runs again.
nlohmann::json AgainAfter(Snapshot& snapshot, const pipeline::Step* step);

}  // namespace keypose::studio
