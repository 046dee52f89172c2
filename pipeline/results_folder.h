// out/: copies of chosen results under names for people.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/artifact_store.h"
#include "pipeline/graph.h"

namespace keypose::pipeline {

/// Keeps out/ equal to what the steps made. Files there are copies (sharing blocks where the file
/// system can): editing one never reaches the cache. A file that a person changed is kept beside
/// the restored one as NAME.mine.
class ResultsFolder {
 public:
  /// @param out          the project's out/
  /// @param memory_file  remembers which files were put there
  ResultsFolder(Disk& disk, std::filesystem::path out, std::filesystem::path memory_file);

  /// Brings the step's named results up to date, and removes those that it no longer has.
  /// @return lines for a person
  std::vector<std::string> Publish(const Step& step, const Artifact& artifact);
  /// Removes results of steps that the graph no longer has.
  /// @return lines for a person
  std::vector<std::string> DropStepsOutside(const Graph& graph);
  /// Reads all results: those that have changed and show it in no time or size are looked at anew
  /// by the next run.
  /// @return lines for a person
  std::vector<std::string> Verify();
  void Save();
  const std::filesystem::path& out() const { return out_; }

 private:
  struct Entry {
    std::string step;
    std::string hash;  ///< of what was put there; empty: nothing yet
    std::string next;  ///< of what is being put there: a killed run may have done so already
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
