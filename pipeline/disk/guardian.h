// The small processes between the runner and a stage.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace keypose::pipeline {

/// What a guardian reports when its stage has ended.
struct GuardianResult {
  std::int32_t exit_code = 0;  ///< 128 + signal if a signal ended it
  std::int64_t peak_bytes = 0;
};

/// The runner's ends of the pipes to a guardian.
struct Guarded {
  int guardian_pid = -1;
  int control = -1;   ///< write 'T' to terminate the stage, 'K' to kill it; closing it (also by
                      ///< exiting) kills it
  int progress = -1;  ///< the stage's progress lines; non-blocking
  int result = -1;    ///< one GuardianResult
};

/// Starts a guardian, which starts the program in its own process group. If the runner dies, the
/// guardian kills all processes that the program started, in any process group (the guardian is
/// their subreaper), and then ends. The guardian has a guardian itself, which does the same if the
/// first is killed.
///
/// @param arguments, environment  complete argv and envp
/// @param keep_open  a descriptor that the guardian keeps open until all processes have stopped
/// (the project's lock), or -1
/// @throws DiskError  the log cannot be opened @throws ToolError  no process could be started
Guarded StartGuarded(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& environment, const std::string& folder,
                     const std::string& log, int keep_open);

}  // namespace keypose::pipeline
