// Events for all open tabs (server-sent events).
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>

namespace keypose::studio {

class EventHub {
 public:
  /// @param data  one line of JSON
  void Send(const std::string& type, const std::string& data);
  /// Wakes all tabs for the last time.
  void Close();

  /// A tab that listens. All tabs are told how many there are.
  class Tab {
   public:
    explicit Tab(EventHub& hub);
    ~Tab();
    Tab(const Tab&) = delete;
    Tab& operator=(const Tab&) = delete;
    /// The events since the last call, as server-sent events. Waits for some seconds, then returns
    /// a comment, which keeps the connection open. Empty: the hub is closed.
    std::string Next();

   private:
    EventHub& hub_;
    std::uint64_t next_;
  };

 private:
  void Count(int change);

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::string> events_;  ///< the newest ones
  std::uint64_t end_ = 0;           ///< number of events so far
  int tabs_ = 0;
  bool closed_ = false;
};

}  // namespace keypose::studio
