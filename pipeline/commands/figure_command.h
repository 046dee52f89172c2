// `keypose figure`: what the figure is, said once by a person in one picture.
#pragma once

#include <string>
#include <vector>

#include "core/values/errors.h"

namespace keypose::pipeline {

struct FigureOptions {
  std::string folder;               ///< -C
  std::string pose, shot;           ///< one of them; both empty: the only one that there is
  std::vector<std::string> at;      ///< PICTURE:X,Y or PICTURE:X,Y-X,Y...: this is the figure
  std::vector<std::string> not_at;  ///< the same: this is not
  bool clear = false;               ///< what was said before is taken back first
  bool changes() const { return clear || !at.empty() || !not_at.empty(); }
};

/// Writes what is said into pipeline.yaml, and prints what is said now, what will run again and the
/// next command.
/// @throws UsageError  no such pose, shot, photograph, camera or frame (names the nearest), a place
/// outside of the picture, or a stage that cannot be told
/// @throws InputError, DiskError  a picture or film that cannot be read
ExitCode FigureCommand(const FigureOptions& options);

}  // namespace keypose::pipeline
