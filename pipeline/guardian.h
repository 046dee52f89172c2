// The small processes between the runner and a stage.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace keypose::pipeline {

/// What a guardian says when its stage is gone.
struct GuardianResult {
  std::int32_t exit_code = 0;  ///< 128 + signal when a signal ended it
  std::int64_t peak_bytes = 0;
};

/// Ends of pipes, in the runner.
struct Guarded {
  int guardian_pid = -1;
  int control = -1;   ///< write 'T' to ask the stage to stop, 'K' to kill it; closing it (also by
                      ///< dying) kills it
  int progress = -1;  ///< the stage's progress lines; non-blocking
  int result = -1;    ///< one GuardianResult
};

/// Starts a guardian, which starts the program in a process group of its own, and outlives the
/// runner just long enough to kill all that the program started, whatever process group that moved
/// to (the guardian is their subreaper). The guardian has one itself, which does the same when the
/// guardian is killed.
///
/// @param arguments, environment  whole argv and envp
/// @param keep_open  a descriptor that the guardian holds until all is stopped (the project's
/// lock), or -1
/// @throws DiskError  the log cannot be opened @throws ToolError  no process could be made
Guarded StartGuarded(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& environment, const std::string& folder,
                     const std::string& log, int keep_open);

}  // namespace keypose::pipeline
