// Relays what a program of Keypose tells in lines to the page, and keeps the state of its session
// for pages that are opened in the middle of a session.
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

/// What a page needs that is opened in the middle of a session.
struct SessionState {
  bool running = false;
  std::uint64_t number = 0;         ///< of the last event
  std::vector<std::string> events;  ///< JSON objects of this session that still count
  int exit_code = 0;                ///< of the last session, when none is running
  std::string message;              ///< what it said, if it failed
};

/// Called from the relay's own thread.
struct SessionListener {
  /// @param number  one more for each event, over all sessions
  std::function<void(std::uint64_t number, const std::string& event)> event;
  std::function<void(std::uint64_t number, int exit_code, const std::string& message)> ended;
};

class SessionRelay {
 public:
  /// What differs between programs.
  struct Ways {
    /// Whether a line is an event for the page. Called from the relay's thread.
    std::function<bool(const std::string& line)> is_event;
    /// Adds an event to those of the state, and drops those that count no more.
    std::function<void(const std::string& event, std::vector<std::string>* events)> keep;
    std::string farewell;  ///< the line that asks the program to end
  };

  SessionRelay(Ways ways, SessionListener listener);
  /// Asks the session to end, and does not wait for it.
  ~SessionRelay();

  /// @param prepare  called when no session is at work, before the program starts
  /// @param greeting  the first line that the program is told; empty: none
  /// @throws LockedError  a session is at work already @throws DiskError
  void Start(const std::vector<std::string>& words, const std::filesystem::path& folder,
             const std::filesystem::path& error_file, const std::function<void()>& prepare,
             const std::string& greeting);
  /// @throws UsageError  no session listens
  void Say(const std::string& line);
  /// As Ctrl-C.
  void Interrupt();
  SessionState State() const;
  bool running() const { return running_; }

 private:
  void Relay();
  void Take(const std::string& line);
  void End();

  const Ways ways_;
  const SessionListener listener_;
  mutable std::mutex mutex_;
  std::unique_ptr<TalkingChild> child_;
  std::filesystem::path error_file_;
  std::thread thread_;
  std::atomic<bool> leave_ = false, running_ = false;
  SessionState state_;
};

}  // namespace keypose::studio
