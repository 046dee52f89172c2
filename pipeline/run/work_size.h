// Estimates the time of a step that has never run, from the photographs that it derives from.
#pragma once

#include "pipeline/disk/disk.h"
#include "pipeline/graph/graph.h"

namespace keypose::pipeline {

/// Width times height from a JPEG's header; for other formats and damaged files, an estimate from
/// the file's size.
/// @return [megapixels]
double MegapixelsOf(const std::string& name, const std::string& content);

/// Estimates from `cost` in the pipeline file. Reads one photograph per folder and assumes the
/// others are as large.
class WorkSize {
 public:
  /// Keeps references.
  /// @param project  the project's root folder
  WorkSize(const Graph& graph, const Disk& disk, std::filesystem::path project);
  /// @return [s] on one core; negative if the step has no cost
  double CoreSeconds(int step);

 private:
  struct Photographs {
    double count = 0, megapixels = 0;
  };
  Photographs In(const std::filesystem::path& folder);

  const Graph& graph_;
  const Disk& disk_;
  std::filesystem::path project_;
  std::map<std::filesystem::path, Photographs> known_;
};

}  // namespace keypose::pipeline
