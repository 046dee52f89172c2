// Starts `keypose shoot`, relays its events, and passes commands on (docs/shoot.md, --commands).
// The session is in the project's files: whoever starts it again goes on where it was.
#pragma once

#include <atomic>
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

/// As the flags of `keypose shoot` say.
struct ShootSetup {
  std::string pose, camera, turntable;
  std::vector<double> rings_deg;
  int angles = 24;
  int flips = 0;
};

/// What a page needs that is opened in the middle of a session.
struct ShootStory {
  bool running = false;
  std::uint64_t number = 0;         ///< of the last event
  std::vector<std::string> events;  ///< JSON objects; those that later ones replace are left out
  int exit_code = 0;                ///< of the last session, when none is running
  std::string message;              ///< what it said, if it failed
};

class ShootControl {
 public:
  /// Called from the control's own thread.
  struct Listener {
    /// @param number  one more for each event, over all sessions
    std::function<void(std::uint64_t number, const std::string& event)> event;
    std::function<void(std::uint64_t number, int exit_code, const std::string& message)> ended;
  };

  ShootControl(std::filesystem::path project, Listener listener);
  /// Asks the session to end, and does not wait for it.
  ~ShootControl();

  /// @throws LockedError  a session is at work already @throws DiskError
  void Start(const ShootSetup& setup);
  /// @param command  one JSON object in one line @throws UsageError  no session listens
  void Say(const std::string& command);
  /// As Ctrl-C: also a camera that does not answer is left.
  void Interrupt();
  ShootStory Story() const;
  /// The newest picture of the live view; it may not be there.
  std::filesystem::path LiveFile() const { return File("live.jpg"); }

 private:
  void Relay();
  void Take(const std::string& line);
  void End();
  std::filesystem::path File(const char* name) const;

  const std::filesystem::path project_;
  const Listener listener_;
  mutable std::mutex mutex_;
  std::unique_ptr<TalkingChild> child_;
  std::thread relay_;
  std::atomic<bool> leave_ = false;
  ShootStory story_;
};

}  // namespace keypose::studio
