// Whether what a step reads stayed as it was while the step ran.
#pragma once

#include <map>
#include <string>

#include "pipeline/plan.h"

namespace keypose::pipeline {

/// The sizes, times and inodes of all that a step reads from outside of the cache, and of the
/// programs that it runs: what is changed and changed back has other times.
using Stamps = std::map<std::string, FileStat>;

class InputWatch {
 public:
  /// Keeps references to both.
  InputWatch(const Plan& plan, Workshop& workshop) : plan_(plan), workshop_(workshop) {}

  Stamps Look(int step) const;

  /// What the step may have read that its fingerprint does not say, for a person; empty: nothing.
  /// It looks at files of the project and at the stage's programs, against `before` and against
  /// what the plan hashed, and at the artifacts that the step reads, which another program may have
  /// damaged.
  /// @param before  of the same step, from before it ran
  std::string Changed(int step, const Stamps& before) const;

 private:
  const Plan& plan_;
  Workshop& workshop_;
};

}  // namespace keypose::pipeline
