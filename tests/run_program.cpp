#include "tests/run_program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "core/testing/paths.h"

namespace keypose::tests {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// As KEYPOSE_SLOWER of cmake/KeyposeTargets.cmake.
#if defined(KEYPOSE_SANITIZED)
constexpr double kSlower = 12;
#else
constexpr double kSlower = 1;
#endif

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<std::string> Environment(const std::vector<std::string>& changes) {
  std::vector<std::string> out = changes;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry, name = text.substr(0, text.find('=') + 1);
    bool replaced = false;
    for (const auto& change : changes) replaced = replaced || change.starts_with(name);
    if (!replaced) out.push_back(text);
  }
  return out;
}

std::vector<char*> Pointers(std::vector<std::string>& words) {
  std::vector<char*> out;
  for (auto& word : words) out.push_back(word.data());
  out.push_back(nullptr);
  return out;
}

std::string Found(const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  const fs::path built = fs::path(BinFolder()) / name;
  if (fs::exists(built)) return built;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((fs::path(folder) / name).c_str(), X_OK) == 0) return fs::path(folder) / name;
  }
  return "";
}

}  // namespace

Program::Program(const std::vector<std::string>& command, const fs::path& folder,
                 const std::vector<std::string>& environment) {
  std::vector<std::string> words = command, entries = Environment(environment);
  words[0] = Found(words[0]);
  if (words[0].empty())
    throw std::runtime_error("no program " + command[0] + " in " + BinFolder() +
                             " or on PATH; build it first");
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const auto arguments = Pointers(words), variables = Pointers(entries);
  pid_ = fork();
  if (pid_ == 0) {
    setpgid(0, 0);
    const int nothing = open("/dev/null", O_RDONLY);
    if (chdir(folder.c_str()) != 0 || dup2(nothing, 0) < 0 || dup2(ends[1], 1) < 0 ||
        dup2(ends[1], 2) < 0)
      _exit(126);
    execve(arguments[0], arguments.data(), variables.data());
    _exit(127);
  }
  setpgid(pid_, pid_);  // in parent and child, whichever runs first
  close(ends[1]);
  pipe_ = ends[0];
}

Program::~Program() {
  if (!ended_) {
    SendSignal(SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (pipe_ >= 0) close(pipe_);
}

void Program::SendSignal(int signal) const { kill(-pid_, signal); }

void Program::Read(int milliseconds) {
  if (pipe_ < 0) {
    usleep(milliseconds * 1000);
    return;
  }
  pollfd waiting{pipe_, POLLIN, 0};
  if (poll(&waiting, 1, milliseconds) <= 0) return;
  char buffer[4096];
  const ssize_t count = read(pipe_, buffer, sizeof buffer);
  if (count > 0) {
    result_.output.append(buffer, count);
  } else {
    close(pipe_);
    pipe_ = -1;
  }
}

bool Program::running() {
  if (ended_) return false;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
  ended_ = true;
  result_.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  // Reads the rest of the pipe. Grandchildren may keep the other end open, so stop when no data
  // comes.
  for (std::size_t before = ~std::size_t{0}; pipe_ >= 0 && before != result_.output.size();) {
    before = result_.output.size();
    Read(20);
  }
  return false;
}

bool Program::WaitForOutput(const std::string& text, double seconds) {
  const auto start = Clock::now();
  seconds *= kSlower;
  while (result_.output.find(text) == std::string::npos) {
    if (!running() || SecondsSince(start) > seconds)
      return result_.output.find(text) != std::string::npos;
    Read(20);
  }
  return true;
}

RunResult Program::Wait(double seconds) {
  const auto start = Clock::now();
  seconds *= kSlower;
  while (running()) {
    Read(20);
    if (SecondsSince(start) < seconds) continue;
    SendSignal(SIGKILL);
    waitpid(pid_, nullptr, 0);
    ended_ = true;
    result_.output += "\n[killed by the test after " + std::to_string(seconds) + " s]";
  }
  return result_;
}

RunResult RunProgram(const std::vector<std::string>& command, const fs::path& folder,
                     const std::vector<std::string>& environment, double seconds) {
  return Program(command, folder, environment).Wait(seconds);
}

bool HasProgram(const std::string& name) { return !Found(name).empty(); }

}  // namespace keypose::tests
