// One run at a time on a project.
#pragma once

#include <filesystem>
#include <string>

namespace keypose::pipeline {

/// Held while it lives; the operating system lets go of it when the process and all that it started
/// are gone, however they end.
class ProjectLock {
 public:
  /// @param state_folder  the project's .keypose; made when missing
  /// @param what          the command, for the message to others
  /// @throws LockedError  another process has it: names its pid, host and since when
  /// @throws DiskError    the lock file cannot be written
  ProjectLock(const std::filesystem::path& state_folder, const std::string& what);
  ~ProjectLock();
  ProjectLock(const ProjectLock&) = delete;
  ProjectLock& operator=(const ProjectLock&) = delete;
  int fd() const { return fd_; }

 private:
  std::filesystem::path file_;
  int fd_ = -1;
};

/// `keypose unlock`: says who holds the lock, or clears what a dead process left.
/// @param force  take the lock away although it is held (from a machine that is gone, on a shared
/// file system)
/// @return lines for a person @throws LockedError  it is held, and may not be taken away
std::string Unlock(const std::filesystem::path& state_folder, bool force);

}  // namespace keypose::pipeline
