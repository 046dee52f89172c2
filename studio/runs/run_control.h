// Starts, follows and stops `keypose run`. The run writes its progress to a file, so that it
// outlives a studio that was killed, and the next studio goes on following it.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace keypose::studio {

struct RunSelection {
  std::vector<std::string> from, until, only, force;
};

class RunControl {
 public:
  /// What the follower tells; called from its own thread.
  struct Listener {
    std::function<void(const std::string& line)> line;  ///< one JSON object
    std::function<void(int exit_code, const std::string& message)> ended;
  };

  RunControl(std::filesystem::path project, Listener listener);
  /// A run at work goes on; the next studio takes it up.
  ~RunControl();

  bool running() const { return running_; }
  /// @throws LockedError  a run is at work already @throws DiskError
  void Start(const RunSelection& selection);
  /// Asks the run to stop, as Ctrl-C would; it ends soon after.
  void Stop();
  /// Follows a run that an earlier studio has started, if it is still at work.
  void TakeUp();

 private:
  void Follow(int pid, bool own);
  std::filesystem::path File(const char* name) const;

  const std::filesystem::path project_;
  const Listener listener_;
  std::mutex mutex_;
  std::thread follower_;
  std::atomic<bool> running_ = false, leave_ = false;
  std::atomic<int> pid_ = 0;
};

}  // namespace keypose::studio
