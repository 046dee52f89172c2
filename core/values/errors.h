// One exception type for each kind of fault, and the program's exit code for it.
#pragma once

#include <stdexcept>
#include <string>

namespace keypose {

/// Exit codes of all programs. Other programs rely on them.
enum class ExitCode {
  kOk = 0,
  kBug = 1,
  kUsage = 2,
  kInput = 3,
  kDisk = 4,
  kTool = 5,
  kQuality = 6,
  kLocked = 7,
  kInterrupted = 130
};

/// Base of all faults that a user can act on. The message says what is wrong, where, and what to
/// do.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

struct UsageError : Error {
  explicit UsageError(const std::string& m) : Error(ExitCode::kUsage, m) {}
};  ///< flags, options, YAML
struct InputError : Error {
  explicit InputError(const std::string& m) : Error(ExitCode::kInput, m) {}
};  ///< photographs, meshes, landmarks
struct DiskError : Error {
  explicit DiskError(const std::string& m) : Error(ExitCode::kDisk, m) {}
};  ///< cannot read or write, disk full
struct ToolError : Error {
  explicit ToolError(const std::string& m) : Error(ExitCode::kTool, m) {}
};  ///< missing or failed program
struct SolverError : Error {
  explicit SolverError(const std::string& m) : Error(ExitCode::kTool, m) {}
};  ///< singular or diverged system
struct QualityError : Error {
  explicit QualityError(const std::string& m) : Error(ExitCode::kQuality, m) {}
};  ///< a gate failed
struct LockedError : Error {
  explicit LockedError(const std::string& m) : Error(ExitCode::kLocked, m) {}
};
struct Cancelled : Error {
  Cancelled() : Error(ExitCode::kInterrupted, "interrupted") {}
};

}  // namespace keypose
