// Detects whether a step's inputs changed while the step ran.
#pragma once

#include <map>
#include <string>

#include "pipeline/run/plan.h"

namespace keypose::pipeline {

/// The sizes, times and inodes of all files that a step reads from outside the cache, and of the
/// programs that it runs. A file that was changed and changed back has other times.
using Stamps = std::map<std::string, FileStat>;

class InputWatch {
 public:
  /// Keeps references to both.
  InputWatch(const Plan& plan, Workshop& workshop) : plan_(plan), workshop_(workshop) {}

  Stamps Look(int step) const;

  /// A message for the user about inputs that changed since they were hashed for the fingerprint;
  /// empty if none did. Compares the project's files and the stage's programs with `before` and
  /// with what the plan hashed. Also checks the artifacts that the step reads, since another
  /// program may have damaged them.
  /// @param before  stamps of the same step, taken before it ran
  std::string Changed(int step, const Stamps& before) const;

 private:
  const Plan& plan_;
  Workshop& workshop_;
};

}  // namespace keypose::pipeline
