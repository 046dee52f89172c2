// The project that is shot into: its folders, and the pose in its pipeline.yaml.
#pragma once

#include <filesystem>
#include <string>

namespace keypose::capture::shoot {

/// Whether a text may be a pose's name: letters and digits of any script, '-' and '_'.
bool IsPoseName(const std::string& name);

/// Makes pipeline.yaml if there is none, and adds the pose if it is not in it; comments and order
/// stay. A timeline that only lists the poses gets the new one at its end.
/// @return the folder of the pose's photographs, absolute: as the file says, else photos/POSE
/// @throws UsageError  the name is none, or the file is written in a way that cannot be added to
/// @throws DiskError
std::filesystem::path AddPose(const std::filesystem::path& project, const std::string& pose);

/// Held while this object lives: one `keypose shoot` at a time in a project.
class ShootLock {
 public:
  /// @throws LockedError  another one is at work
  /// @throws DiskError
  explicit ShootLock(const std::filesystem::path& state_folder);
  ~ShootLock();
  ShootLock(const ShootLock&) = delete;
  ShootLock& operator=(const ShootLock&) = delete;

 private:
  int fd_ = -1;
};

}  // namespace keypose::capture::shoot
