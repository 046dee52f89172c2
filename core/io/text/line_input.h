// Lines from a terminal or a pipe, without waiting for them longer than asked.
#pragma once

#include <optional>
#include <string>

namespace keypose {

class LineInput {
 public:
  /// @param fd  is read, never closed
  explicit LineInput(int fd) : fd_(fd) {}
  /// The next line without its end; nothing if none came in time. Lines over 64 KiB are dropped.
  std::optional<std::string> Next(double timeout_s);
  /// The end was reached and every line given.
  bool over() const { return ended_ && arrived_.empty(); }

 private:
  std::optional<std::string> Taken();
  int fd_;
  bool ended_ = false, drops_ = false;
  std::string arrived_;
};

/// Ctrl-C, `kill` or the end of the terminal; a second one ends the program at once.
void CatchInterrupts();
bool WasInterrupted();

}  // namespace keypose
