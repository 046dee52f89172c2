#include "studio/runs/children.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

std::vector<char*> Words(const std::vector<std::string>& arguments) {
  std::vector<char*> words;
  for (const std::string& argument : arguments)
    words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  return words;
}

/// -1: nothing to read, and nobody who reads.
struct Streams {
  int in = -1, out = -1, error = -1;
};

/// In the new process: a session of its own, so that Ctrl-C on the studio does not reach it twice.
[[noreturn]] void Become(const std::vector<char*>& words, const char* folder, Streams to) {
  setsid();
  for (int* stream : {&to.in, &to.out, &to.error})
    if (*stream < 0) *stream = open("/dev/null", O_RDWR);
  if (chdir(folder) != 0 || dup2(to.in, 0) < 0 || dup2(to.out, 1) < 0 || dup2(to.error, 2) < 0)
    _exit(126);
  execv(words[0], words.data());
  _exit(127);
}

/// The exit code, or 128 and the signal.
int CodeOf(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

int WaitFor(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return CodeOf(status);
}

void CloseIt(int& fd) {
  if (fd >= 0) close(fd);
  fd = -1;
}

struct Pipe {
  int read = -1, write = -1;
};

/// To a program and from it.
struct PipePair {
  Pipe to, from;
};

PipePair MakePipes() {
  int to[2], from[2];
  if (pipe2(to, O_CLOEXEC) == 0) {
    if (pipe2(from, O_CLOEXEC) == 0) return {{to[0], to[1]}, {from[0], from[1]}};
    const int reason = errno;
    close(to[0]);
    close(to[1]);
    errno = reason;
  }
  throw DiskError(std::string("cannot make a pipe: ") + std::strerror(errno));
}

int OpenToWrite(const fs::path& file) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) throw DiskError("cannot write " + file.string() + ": " + std::strerror(errno));
  return fd;
}

/// Reads until the program has closed its output, or the time is over.
bool ReadAll(int fd, double seconds, std::string* text) {
  constexpr std::size_t kMost = 64 << 10;
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  char buffer[4096];
  while (Clock::now() < end) {
    pollfd wait{fd, POLLIN, 0};
    if (poll(&wait, 1, 200) == 0) continue;
    const ssize_t count = read(fd, buffer, sizeof buffer);
    if (count <= 0) return true;
    text->append(buffer, static_cast<std::size_t>(count));
    if (text->size() > 2 * kMost) text->erase(0, text->size() - kMost);
  }
  return false;
}

}  // namespace

ChildResult RunChild(const std::vector<std::string>& arguments, const fs::path& folder,
                     double seconds) {
  return PipedChild(arguments, folder).Finish("", seconds);
}

PipedChild::PipedChild(const std::vector<std::string>& arguments, const fs::path& folder) {
  auto [to, from] = MakePipes();
  const std::vector<char*> words = Words(arguments);
  const std::string where = folder.string();
  pid_ = fork();
  if (pid_ == 0) Become(words, where.c_str(), {to.read, from.write, from.write});
  CloseIt(to.read);
  CloseIt(from.write);
  input_ = to.write;
  output_ = from.read;
  if (pid_ > 0) return;
  CloseIt(input_);
  CloseIt(output_);
  throw DiskError(std::string("cannot start a program: ") + std::strerror(errno));
}

PipedChild::~PipedChild() {
  CloseIt(input_);
  CloseIt(output_);
  int status = 0;
  if (pid_ > 0) waitpid(pid_, &status, WNOHANG);
}

ChildResult PipedChild::Finish(const std::string& input, double seconds) {
  // One that does not read it has ended, or will tell why by its output.
  if (!input.empty() && write(input_, input.data(), input.size()) < 0) CloseIt(input_);
  CloseIt(input_);
  ChildResult result;
  const bool ended = ReadAll(output_, seconds, &result.output);
  CloseIt(output_);
  if (!ended) kill(-pid_, SIGTERM);
  const int code = WaitFor(pid_);
  pid_ = -1;
  result.exit_code = ended ? code : 124;
  return result;
}

int StartChild(const std::vector<std::string>& arguments, const fs::path& folder,
               const fs::path& output, const fs::path& error) {
  const int out = OpenToWrite(output), err = OpenToWrite(error);
  const std::vector<char*> words = Words(arguments);
  const std::string where = folder.string();
  const pid_t pid = fork();
  if (pid == 0) Become(words, where.c_str(), {-1, out, err});
  close(out);
  close(err);
  if (pid < 0) throw DiskError(std::string("cannot start a program: ") + std::strerror(errno));
  return pid;
}

std::string MarkOfProcess(int pid) {
  std::string boot, stat;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  std::getline(std::ifstream(fmt::format("/proc/{}/stat", pid)), stat);
  // After the name, which may hold anything, come the fields from the third on: its state, and as
  // the 22nd when it was started, in ticks since the machine was.
  const auto name_end = stat.rfind(')');
  std::istringstream fields(name_end == std::string::npos ? "" : stat.substr(name_end + 1));
  std::string state, field;
  fields >> state;
  for (int i = 4; i <= 22; ++i) fields >> field;
  return !fields || state == "Z" ? "" : boot + " " + field;
}

void LetGo(const std::vector<std::string>& arguments, const fs::path& folder) {
  const std::vector<char*> words = Words(arguments);
  const std::string where = folder.string();
  const pid_t between = fork();
  if (between < 0) throw DiskError(std::string("cannot start a program: ") + std::strerror(errno));
  if (between == 0) {
    // Its parent ends at once, so that the system collects it when it ends.
    if (fork() != 0) _exit(0);
    Become(words, where.c_str(), {});
  }
  WaitFor(between);
}

std::string WhatItSaid(const fs::path& error, int exit_code) {
  std::string text;
  try {
    text = ReadFile(error);
  } catch (const Error&) {
    // the file is gone: the exit code says something
  }
  return ErrorIn(text, exit_code);
}

std::string ErrorIn(const std::string& said, int exit_code) {
  std::string text = WithoutOddBytes(said);
  // "keypose: error: ..." or, of a stage, "keypose armature edit: error: ...".
  const std::string mark = ": error: ";
  const auto at = text.find(mark);
  const auto line = at == std::string::npos ? at : text.rfind('\n', at) + 1;
  if (line != std::string::npos && text.compare(line, 7, "keypose") == 0)
    text.erase(0, at + mark.size());
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.empty() && exit_code != 0
             ? fmt::format("the program ended with exit code {}", exit_code)
             : text;
}

std::string WarningsIn(const std::string& said) {
  // "armature bake: warning: ...".
  const std::string mark = ": warning: ";
  std::string warnings;
  std::istringstream lines(WithoutOddBytes(said));
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(mark); at != std::string::npos)
      warnings += (warnings.empty() ? "" : "\n") + line.substr(at + mark.size());
  return warnings;
}

TalkingChild::TalkingChild(const std::vector<std::string>& arguments, const fs::path& folder,
                           const fs::path& error) {
  int err = OpenToWrite(error);
  auto [to, from] = MakePipes();
  const std::vector<char*> words = Words(arguments);
  const std::string where = folder.string();
  pid_ = fork();
  if (pid_ == 0) Become(words, where.c_str(), {to.read, from.write, err});
  for (int* fd : {&to.read, &from.write, &err}) CloseIt(*fd);
  input_ = to.write;
  output_ = from.read;
  // A program that does not read must not hold up who speaks to it.
  fcntl(input_, F_SETFL, O_NONBLOCK);
  if (pid_ > 0) return;
  CloseIt(input_);
  CloseIt(output_);
  throw DiskError(std::string("cannot start a program: ") + std::strerror(errno));
}

TalkingChild::~TalkingChild() {
  CloseIt(input_);
  CloseIt(output_);
  int status = 0;
  if (pid_ > 0) waitpid(pid_, &status, WNOHANG);
}

bool TalkingChild::Say(const std::string& line) {
  const std::string text = line + "\n";
  return input_ >= 0 &&
         write(input_, text.data(), text.size()) == static_cast<ssize_t>(text.size());
}

TalkingChild::Heard TalkingChild::Hear(std::string* line) {
  constexpr int kPatience_ms = 100;
  if (const auto end = unread_.find('\n'); end != std::string::npos) {
    *line = unread_.substr(0, end);
    unread_.erase(0, end + 1);
    return Heard::kLine;
  }
  pollfd wait{output_, POLLIN, 0};
  if (poll(&wait, 1, kPatience_ms) <= 0) return Heard::kNothing;
  char buffer[16 << 10];
  const ssize_t count = read(output_, buffer, sizeof buffer);
  if (count <= 0) return Heard::kEnd;
  unread_.append(buffer, static_cast<std::size_t>(count));
  return Heard::kNothing;
}

void TalkingChild::Interrupt() {
  // Its own children too; it may not have its session yet.
  if (pid_ > 0 && kill(-pid_, SIGINT) != 0) kill(pid_, SIGINT);
}

int TalkingChild::Wait() {
  const int code = pid_ > 0 ? WaitFor(pid_) : 0;
  pid_ = -1;
  return code;
}

}  // namespace keypose::studio
