// The project that is shot into: its folders, and the pose in its pipeline.yaml.
#pragma once

#include <filesystem>
#include <string>

namespace keypose::capture::shoot {

/// Whether a text may be a pose's name: letters and digits of any script, '-' and '_'.
bool IsPoseName(const std::string& name);

/// A pose that is in the project's pipeline.yaml.
struct PosePlace {
  std::filesystem::path
      folder;             ///< of its photographs, absolute: as the file says, else photos/POSE
  std::string bent_from;  ///< the template that is bent into its few photographs; "": it is scanned
};

/// Makes pipeline.yaml if there is none, and adds the pose if it is not in it; comments and order
/// stay. A timeline that only lists the poses gets the new one at its end. A pose after the first
/// that gets fewer photographs than a scan needs, and has none yet, gets `method: fit`.
/// @param photographs  that the pose will get
/// @throws UsageError  the name is none, or the file is written in a way that cannot be added to
/// @throws DiskError
PosePlace AddPose(const std::filesystem::path& project, const std::string& pose, int photographs);

/// Whether the project has another pose than this one; false where its pipeline.yaml cannot be
/// read.
bool HasOtherPose(const std::filesystem::path& project, const std::string& pose);

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
