// Programs that the studio starts: found beside it, stopped with it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::studio {

struct ChildResult {
  int exit_code = 0;
  std::string output;  ///< standard output and error, at most the last 64 kB
};

/// Runs a program to its end and returns what it said.
/// @param seconds  after this long it is stopped (exit code 124)
ChildResult RunChild(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                     double seconds);

/// A program that is given its input at once, and whose output and error are one.
class PipedChild {
 public:
  /// @throws DiskError  it cannot be started
  PipedChild(const std::vector<std::string>& arguments, const std::filesystem::path& folder);
  /// Closes its input and leaves it alone.
  ~PipedChild();
  PipedChild(const PipedChild&) = delete;
  PipedChild& operator=(const PipedChild&) = delete;

  /// Writes all its input and waits for its end, as RunChild does.
  ChildResult Finish(const std::string& input, double seconds);

 private:
  int pid_ = -1, input_ = -1, output_ = -1;
};

/// Starts a program that goes on by itself; its standard output and error go to files.
/// @return its process id @throws DiskError  it cannot be started
int StartChild(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
               const std::filesystem::path& output, const std::filesystem::path& error);

/// Which process that is, also among those that have its number later or on another machine; "" if
/// there is none.
std::string MarkOfProcess(int pid);

/// Starts a program that is the person's from then on, such as a browser: it outlives the studio,
/// nobody reads what it says, and nobody waits for it. @throws DiskError  it cannot be started
void LetGo(const std::vector<std::string>& arguments, const std::filesystem::path& folder);

/// The words of the error in what a program that failed has said.
std::string ErrorIn(const std::string& said, int exit_code);

/// The warnings in what a stage has said, a line each; "" if there are none.
std::string WarningsIn(const std::string& said);

/// What a program that failed has said, without the lines that only a terminal needs.
/// @param error  the file of its standard error
std::string WhatItSaid(const std::filesystem::path& error, int exit_code);

/// A program that is talked to in lines, through its standard input and output.
class TalkingChild {
 public:
  /// @param error  the file for its standard error @throws DiskError  it cannot be started
  TalkingChild(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
               const std::filesystem::path& error);
  /// Closes its input and leaves it alone: it ends when it has read the end of its input.
  ~TalkingChild();
  TalkingChild(const TalkingChild&) = delete;
  TalkingChild& operator=(const TalkingChild&) = delete;

  /// False when it does not listen any more. May be called from another thread than Hear.
  bool Say(const std::string& line);
  /// What Hear has found.
  enum class Heard { kLine, kNothing, kEnd };
  /// Its next line, without the end of line; kNothing after a tenth of a second without one.
  Heard Hear(std::string* line);
  /// As Ctrl-C would.
  void Interrupt();
  /// Waits for its end, and returns the exit code, or 128 and the signal.
  int Wait();

 private:
  int pid_ = -1, input_ = -1, output_ = -1;
  std::string unread_;
};

}  // namespace keypose::studio
