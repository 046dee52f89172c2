// What a page needs to show a live puppet by itself: files once, then a line for each pose.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "armature/live/posed_puppet.h"
#include "armature/live/puppet_files.h"

namespace keypose::armature {

/// What a line says besides the pose.
struct PageLine {
  double time_s = 0;           ///< since the stream began
  bool fresh = true;           ///< the controller answered
  std::vector<double> values;  ///< of the armature's joints [rad, m]
  std::vector<int> held;       ///< joints whose counter jumped
  std::vector<int> wraps;      ///< for each joint how often its counter has wrapped; may be empty
  int repeats = 0, damaged = 0;
};

/// The bones in each frame of values, as frames.bin has them. @param frames  of the armature's
/// joints
std::string PoseBytes(const PuppetParts& parts, const std::vector<std::vector<double>>& frames);

/// Writes into a folder, little-endian:
///
///     view.json    sensors, chains, plates with their cameras
///     rest.ply     the mesh at rest, if it is ball and stick
///     weights.bin  for each vertex the numbers of four bones (uint16), then for each their weights
///                  (4 float32)
///     frames.bin   for each recorded frame all bones (7 float32: turn w x y z, then shift)
class PageStream {
 public:
  /// @param own_mesh  the mesh is in a file that the page has already
  /// All references must outlive this. @throws DiskError
  PageStream(const PuppetParts& parts, const PlateFiles& plates, bool own_mesh,
             const std::filesystem::path& folder);

  /// The frames that are recorded already. @throws DiskError
  void TakeUp(const std::vector<std::vector<double>>& frames);
  /// The frame is recorded, perhaps once more. @throws DiskError
  void Record(int frame, const SkeletonPose& pose);

  /// {"pose": number of the line, "time", "fresh", "bones": [7 numbers each], "values": [degrees or
  /// millimetres, or the description's own unit], "held": [...], "wraps": [...], "repeats",
  /// "damaged", "chains": [[near gap, far gap, mean distance from the curve, each over the chain's
  /// length], ...]}
  std::string Line(const PuppetMatcher& matcher, const PageLine& line);

 private:
  std::string ViewText(const PlateFiles& plates) const;

  const PuppetParts& parts_;
  std::filesystem::path folder_;
  long number_ = 0;
};

}  // namespace keypose::armature
