// One run at a time on a project.
#pragma once

#include <filesystem>
#include <string>

namespace keypose::pipeline {

/// The lock is held while this object lives. The operating system releases it when the process and
/// all that it started have ended, in whatever way.
class ProjectLock {
 public:
  /// @param state_folder  the project's .keypose; created if missing
  /// @param what          the command, for the message to others
  /// @throws LockedError  another process holds it; names its pid, host and start time
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

/// Words on who holds the lock; empty if nobody does. Only reads, so it never keeps a run from
/// taking the lock.
std::string LockHolder(const std::filesystem::path& state_folder);

/// `keypose unlock`: reports who holds the lock, or clears the lock of a dead process.
/// @param force  remove the lock although it is held (by a machine that no longer exists, on a
/// shared file system)
/// @return lines for the user @throws LockedError  it is held and `force` is false
std::string Unlock(const std::filesystem::path& state_folder, bool force);

}  // namespace keypose::pipeline
