// The stage programs of a pipeline and their descriptions. Descriptions are remembered while the
// program and its tools stay the same.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/disk/disk.h"
#include "pipeline/disk/process.h"
#include "pipeline/graph/stage_info.h"

namespace keypose::pipeline {

class StageCatalog {
 public:
  /// @param memory_file  file in which descriptions are stored; empty: none
  /// @param shared_file  another one, which all projects of a user share, so that a new project
  /// need not run each program; empty: none
  StageCatalog(Disk& disk, ProcessRunner& processes, std::filesystem::path memory_file,
               std::filesystem::path shared_file = {});

  /// Loads the descriptions of these programs. Programs without a stored one are run in parallel.
  /// @throws ToolError  a program cannot be run, or its output does not follow the stage contract
  void Load(const std::vector<std::filesystem::path>& programs);
  /// @pre Load was called with `program`
  const StageInfo& Get(const std::filesystem::path& program) const;
  int asked() const { return asked_; }  ///< programs that had to be run

 private:
  std::map<std::string, std::optional<FileStat>> ProgramsOf(
      const std::string& program, const std::vector<std::string>& tools) const;
  struct CatalogMemory Remembered(const std::filesystem::path& file) const;
  void Remember(const std::filesystem::path& file, const struct CatalogMemory& memory);
  bool Recall(const std::string& program, const struct CatalogMemory& memory);
  /// Runs the programs, and keeps what they say in `memory`.
  void Ask(const std::vector<std::string>& programs, struct CatalogMemory& memory);
  /// Adds what the programs said to the shared file, and drops programs that are gone from it.
  void Share(const std::vector<std::string>& programs, const struct CatalogMemory& memory);
  /// Takes the answer of a program that was asked, if it is the one of `before`.
  void Learn(const std::string& program, const std::optional<FileStat>& before,
             const ProcessRunner::Answer& answer, struct CatalogMemory& memory);

  Disk& disk_;
  ProcessRunner& processes_;
  std::filesystem::path memory_file_, shared_file_;
  std::map<std::string, StageInfo> stages_;
  int asked_ = 0;
};

}  // namespace keypose::pipeline
