// A stage's program that has loaded its libraries before it is needed.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "studio/runs/children.h"

namespace keypose::studio {

/// One is kept waiting for its arguments (`--await`, see core/stage/awaited_arguments.h). It ends
/// when the studio does, since that closes its input. May be used from several threads.
class WarmProgram {
 public:
  /// @param folder  where it works
  WarmProgram(std::filesystem::path program, std::filesystem::path folder);

  /// Starts one, if none waits.
  void Warm();
  /// As RunChild does. Uses the waiting one, unless the program was replaced since it started, and
  /// has the next one wait.
  /// @param arguments  without the program's name
  ChildResult Run(const std::vector<std::string>& arguments, double seconds);

 private:
  struct Waiting {
    std::unique_ptr<PipedChild> child;
    std::filesystem::file_time_type written;  ///< when the program was
  };
  Waiting Start() const;
  Waiting Take();

  const std::filesystem::path program_, folder_;
  std::mutex mutex_;
  Waiting waiting_;
};

}  // namespace keypose::studio
