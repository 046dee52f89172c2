// What SIGINT, SIGTERM and SIGHUP do to a running stage. Used by stage_main.cpp only.
#pragma once

#include <functional>
#include <thread>

namespace keypose::internal {

/// While this object lives, the first signal asks the stage to stop (Asked), which its algorithms
/// see between their steps. A library's call cannot be asked: when the stage is still at work
/// `grace_s` after the signal, or at the second signal, `give_up` is called from another thread and
/// the process ends with exit code 130. There is one at a time.
class Interruption {
 public:
  /// @param give_up  removes what is unfinished; false: the stage is about to end by itself, and
  /// the process goes on
  Interruption(double grace_s, std::function<bool()> give_up);
  /// Does not return when the process is being ended.
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  static bool Asked();

 private:
  void Watch(double grace_s);

  std::function<bool()> give_up_;
  std::thread watcher_;
};

}  // namespace keypose::internal
