// How much there is to do: the photographs that a step goes back to, and what it may therefore take
// when it has never run.
#pragma once

#include "pipeline/disk.h"
#include "pipeline/graph.h"

namespace keypose::pipeline {

/// Width times height, read from a JPEG's header; for other kinds, and files that are damaged, from
/// the size of the file.
/// @return [megapixels]
double MegapixelsOf(const std::string& name, const std::string& content);

/// Guesses from `cost` in the pipeline file. Looks at one photograph of each folder; the others are
/// taken to be as large.
class WorkSize {
 public:
  /// Keeps references.
  /// @param project  its root folder
  WorkSize(const Graph& graph, const Disk& disk, std::filesystem::path project);
  /// @return [s] of one core; negative where the step states no cost
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
