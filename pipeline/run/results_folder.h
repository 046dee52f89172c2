// out/: copies of chosen results under readable names.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/cache/artifact_store.h"
#include "pipeline/graph/graph.h"

namespace keypose::pipeline {

/// Keeps out/ equal to the steps' results. Its files are copies (sharing blocks where the file
/// system can), so editing one never changes the cache. A file that the user changed is kept beside
/// the restored one as NAME.mine.
class ResultsFolder {
 public:
  /// @param out          the project's out/
  /// @param memory_file  stores which files were put there
  ResultsFolder(Disk& disk, std::filesystem::path out, std::filesystem::path memory_file);

  struct Published {
    std::vector<std::string> notes;  ///< lines for the user
    bool copied = false;             ///< some were not in place
  };
  /// Updates the step's named results, and removes those that it no longer has.
  Published Publish(const Step& step, const Artifact& artifact);
  /// Removes those results of the step whose content is not what it should be: another program
  /// changed what they were copied from.
  void RemoveWrongCopies(const std::string& step);
  /// Removes results of steps that the graph no longer has.
  /// @return lines for the user
  std::vector<std::string> DropStepsOutside(const Graph& graph);
  /// Reads all results. Files that changed without a new size or time are checked again by the next
  /// run.
  /// @return lines for the user
  std::vector<std::string> Verify();
  void Save();
  const std::filesystem::path& out() const { return out_; }

 private:
  struct Entry {
    std::string step;
    std::string hash;  ///< of the file that was put there; empty: none yet
    std::string next;  ///< of the file that is being put there; a killed run may have finished that
    FileStat stat;
  };
  std::map<std::string, Entry> entries_;  ///< by path relative to out/

  void Load();
  bool Unchanged(const std::string& name, const Entry& entry) const;
  bool IsInPlace(const std::string& name, const std::string& step, const std::string& hash);
  void Place(const std::string& name, const std::filesystem::path& from,
             std::vector<std::string>* notes);
  void SetAside(const std::string& name, std::vector<std::string>* notes);
  void Drop(const std::string& name, std::vector<std::string>* notes);

  Disk& disk_;
  std::filesystem::path out_, memory_file_;
  bool changed_ = false;
};

}  // namespace keypose::pipeline
