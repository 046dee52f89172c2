// What was deleted on the pages: bin/NUMBER/ has the files at the places that they had in the
// project, and deleted.json, which says what they were. Nothing of it is ever removed by us.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "studio/project/moves.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// An entry of the bin while it is filled.
class BinEntry {
 public:
  /// @param what  of deleted.json
  BinEntry(const std::filesystem::path& project, Moves& moves, const nlohmann::json& what);
  ~BinEntry();
  BinEntry(const BinEntry&) = delete;
  BinEntry& operator=(const BinEntry&) = delete;

  /// @param file  of the project, or a folder
  void Take(const std::filesystem::path& file);
  /// @return its number
  std::string Keep();

 private:
  std::filesystem::path project_, folder_;
  Moves& moves_;
  bool kept_ = false;
};

/// The entries, the newest first: [{"id", "what": "photographs" or "pose", "pose", "names",
/// "files"}].
nlohmann::json BinJson(const std::filesystem::path& project);

/// A file of an entry. @throws NotFound
std::filesystem::path BinFile(const std::filesystem::path& project, const std::string& id,
                              const std::string& path);

/// Puts photographs of a pose into the bin, each with its RAW file and the mask that was painted
/// over it; those that were left out are no longer named so.
/// @return the entry's id
/// @throws UsageError  no such photograph, or outside of the project
std::string BinPhotographs(Snapshot& snapshot, const std::string& pose,
                           const std::vector<std::string>& names);

/// Puts a pose into the bin: its photographs, landmarks and masks, its keys on the timeline.
/// @throws UsageError  the template while there are other poses, the last pose
std::string BinPose(Snapshot& snapshot, const std::string& pose);

/// Puts everything of an entry back to its place. A pose comes at the end of the poses.
/// @throws UsageError  something else is there by now
void TakeBack(Snapshot& snapshot, const std::string& id);

}  // namespace keypose::studio
