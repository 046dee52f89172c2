// Starts `keypose armature live` for the page, keeps its newest pose, relays its events; and
// `keypose armature bake`. A session's frames are in its folder: whoever starts it again goes on.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "studio/runs/children.h"
#include "studio/runs/session_relay.h"

namespace keypose::studio {

/// Files are named from the project's folder; empty ones are not given.
struct ArmatureSetup {
  std::string take;  ///< name of the recording
  std::string port;  ///< a device, or "simulated"
  std::string description, chains, skeleton, mesh, weights, texture, plate, shot, set, calibration;
  std::string armature_up = "z", skeleton_up = "z";  ///< "y" or "z", in their files
  double fps = 24;
  int step = 2;
};

struct ArmatureState : SessionState {
  bool baking = false;
};

std::filesystem::path ArmatureProgram();
/// Adds flag and value as two words, as a stage takes them; nothing for an empty value.
void AddFlag(const char* name, const std::string& value, std::vector<std::string>* words);
/// Adds the flags of the puppet's files, and of how they are read. @param with_mesh  also of its
/// mesh and the weights
void AddPuppetFiles(const ArmatureSetup& setup, bool with_mesh, std::vector<std::string>* words);

class ArmatureControl {
 public:
  /// Called from the control's own threads.
  struct Listener : SessionListener {
    std::function<void(int exit_code, const std::string& message)> baked;
    /// The program has its puppet, and the take is of that puppet.
    std::function<void(const ArmatureSetup& setup)> began;
  };

  ArmatureControl(std::filesystem::path project, Listener listener);
  /// Asks the session to end, and does not wait for it; stops a bake.
  ~ArmatureControl();

  /// @throws LockedError  a session is at work already @throws DiskError
  void Start(const ArmatureSetup& setup);
  /// @param line  as typed into `armature live` @throws UsageError  no session listens
  void Say(const std::string& line) { relay_.Say(line); }
  /// As Ctrl-C.
  void Interrupt() { relay_.Interrupt(); }
  ArmatureState State() const;

  /// The newest pose, {"number": N, "pose": {...}}; waits for one with another number than `after`
  /// for at most a second, and then gives "". At once "" when no session runs.
  std::string Pose(std::uint64_t after);

  /// Makes frames of a take's curves. @param between  hold, linear, smooth, or keys for interpolate
  /// @throws LockedError  it bakes already @throws DiskError
  void Bake(const ArmatureSetup& setup, const std::string& between);

  /// Where `live` leaves what a page shows (armature/live/page_stream.h).
  std::filesystem::path PageFolder() const { return project_ / ".keypose/studio/armature"; }
  std::filesystem::path TakeFolder(const std::string& take) const;

 private:
  SessionListener Followed(const SessionListener& listener);
  bool TakePose(const std::string& line);
  void FollowBake();

  const std::filesystem::path project_;
  const Listener listener_;
  mutable std::mutex mutex_;  ///< of the pose, the bake and the set-up
  std::condition_variable posed_;
  std::unique_ptr<TalkingChild> baker_;
  std::thread bake_;
  std::atomic<bool> leave_ = false;
  bool baking_ = false;
  std::string pose_;
  std::uint64_t pose_number_ = 0;
  ArmatureSetup setup_;  ///< of the session
  SessionRelay relay_;   ///< last: its thread uses what is above
};

}  // namespace keypose::studio
