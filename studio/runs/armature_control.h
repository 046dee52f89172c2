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

namespace keypose::studio {

/// Files are named from the project's folder; empty ones are not given.
struct ArmatureSetup {
  std::string take;  ///< name of the recording
  std::string port;  ///< a device, or "simulated"
  std::string description, chains, skeleton, mesh, weights, texture, plate, shot, set, calibration;
  double fps = 24;
  int step = 2;
};

/// What a page needs that is opened in the middle of a session.
struct ArmatureStory {
  bool running = false, baking = false;
  std::uint64_t number = 0;         ///< of the last event
  std::vector<std::string> events;  ///< JSON objects, of this session
  int exit_code = 0;                ///< of the last session, when none is running
  std::string message;              ///< what it said, if it failed
};

class ArmatureControl {
 public:
  /// Called from the control's own threads.
  struct Listener {
    /// @param number  one more for each event, over all sessions
    std::function<void(std::uint64_t number, const std::string& event)> event;
    std::function<void(std::uint64_t number, int exit_code, const std::string& message)> ended;
    std::function<void(int exit_code, const std::string& message)> baked;
  };

  ArmatureControl(std::filesystem::path project, Listener listener);
  /// Asks the session to end, and does not wait for it; stops a bake.
  ~ArmatureControl();

  /// @throws LockedError  a session is at work already @throws DiskError
  void Start(const ArmatureSetup& setup);
  /// @param line  as typed into `armature live` @throws UsageError  no session listens
  void Say(const std::string& line);
  /// As Ctrl-C.
  void Interrupt();
  ArmatureStory Story() const;

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
  void Relay();
  void Take(const std::string& line);
  void End();
  void FollowBake();

  const std::filesystem::path project_;
  const Listener listener_;
  mutable std::mutex mutex_;
  std::condition_variable posed_;
  std::unique_ptr<TalkingChild> child_, baker_;
  std::thread relay_, bake_;
  std::atomic<bool> leave_ = false;
  ArmatureStory story_;
  std::string pose_;
  std::uint64_t pose_number_ = 0;
};

}  // namespace keypose::studio
