// The stage programs that a pipeline names, and what each says of itself; answers are remembered
// while program and tools stay the same.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/disk.h"
#include "pipeline/process.h"
#include "pipeline/stage_info.h"

namespace keypose::pipeline {

class StageCatalog {
 public:
  /// @param memory_file  where answers are remembered; empty: nowhere
  StageCatalog(Disk& disk, ProcessRunner& processes, std::filesystem::path memory_file);

  /// Learns about all these programs, those that are not remembered side by side.
  /// @throws ToolError  one cannot be run, or its answer is not the contract's
  void Load(const std::vector<std::filesystem::path>& programs);
  /// @pre Load was called with it
  const StageInfo& Get(const std::filesystem::path& program) const;
  int asked() const { return asked_; }  ///< programs that had to be run

 private:
  std::map<std::string, std::optional<FileStat>> ProgramsOf(
      const std::string& program, const std::vector<std::string>& tools) const;
  bool Recall(const std::string& program, const struct CatalogMemory& memory);

  Disk& disk_;
  ProcessRunner& processes_;
  std::filesystem::path memory_file_;
  std::map<std::string, StageInfo> stages_;
  int asked_ = 0;
};

}  // namespace keypose::pipeline
