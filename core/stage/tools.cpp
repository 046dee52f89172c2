#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "core/stage/stage.h"
#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

std::string OverrideName(const std::string& program) {
  std::string name = "KEYPOSE_" + program;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return name;
}

/// The program's path; empty when it is not installed.
std::string FindProgram(const std::string& program) {
  if (const char* path = std::getenv(OverrideName(program).c_str()))
    return access(path, X_OK) == 0 ? path : "";
  const char* path_list = std::getenv("PATH");
  std::istringstream folders(path_list ? path_list : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string candidate = (folder.empty() ? "." : folder) + "/" + program;
    if (access(candidate.c_str(), X_OK) == 0 && !fs::is_directory(candidate)) return candidate;
  }
  return "";
}

struct Finished {
  std::string output;
  int status = 0;
  bool interrupted = false;
};

[[noreturn]] void Exec(const std::string& path, const std::vector<std::string>& arguments,
                       const std::vector<std::string>& environment, int out, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // the parent died before prctl took hold
  dup2(out, STDOUT_FILENO);
  dup2(out, STDERR_FILENO);
  for (const std::string& entry : environment) putenv(const_cast<char*>(entry.c_str()));
  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(path.c_str(), argv.data());
  _exit(127);
}

/// Waits for the program and collects its output. Kills the whole process group when `cancelled`
/// returns true.
Finished RunToEnd(const std::string& path, const std::vector<std::string>& arguments,
                  const std::vector<std::string>& environment,
                  const std::function<bool()>& cancelled, bool echo) {
  int pipe_ends[2];
  if (pipe2(pipe_ends, O_CLOEXEC) != 0)
    throw ToolError(fmt::format("cannot start {}: {}", path, std::strerror(errno)));
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw ToolError(fmt::format("cannot start {}: {}", path, std::strerror(errno)));
  if (child == 0) Exec(path, arguments, environment, pipe_ends[1], parent);
  close(pipe_ends[1]);
  setpgid(child, child);
  Finished finished;
  char buffer[4096];
  for (;;) {
    pollfd wait{pipe_ends[0], POLLIN, 0};
    const int ready = poll(&wait, 1, 200);
    if (cancelled() && !finished.interrupted) {
      finished.interrupted = true;
      kill(-child, SIGKILL);
    }
    if (ready <= 0) continue;
    const ssize_t got = read(pipe_ends[0], buffer, sizeof buffer);
    if (got <= 0) break;
    finished.output.append(buffer, static_cast<std::size_t>(got));
    if (echo && write(STDERR_FILENO, buffer, static_cast<std::size_t>(got)) < 0) echo = false;
  }
  close(pipe_ends[0]);
  waitpid(child, &finished.status, 0);
  return finished;
}

std::string HowItEnded(int status) {
  return WIFSIGNALED(status) ? fmt::format("was killed by signal {}", WTERMSIG(status))
                             : fmt::format("failed with exit code {}", WEXITSTATUS(status));
}

std::string LastLines(const std::string& text, int count) {
  std::size_t at = text.size();
  while (at > 0 && text[at - 1] == '\n') --at;
  const std::size_t end = at;
  while (at > 0 && count > 0) {
    --at;
    if (text[at] == '\n') --count;
  }
  return text.substr(at, end - at);
}

}  // namespace

std::string RunTool(StageContext& stage, const std::string& program,
                    const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment) {
  const std::string path = FindProgram(program);
  if (path.empty())
    throw ToolError(
        fmt::format("the program '{0}' is not installed or not on PATH; install it (Debian: "
                    "apt-get install {0}), or set {1} to its path",
                    program, OverrideName(program)));
  const auto cancelled = [&] { return stage.progress() && stage.progress()->cancelled(); };
  Finished finished = RunToEnd(path, arguments, environment, cancelled, true);
  if (finished.interrupted || cancelled()) throw Cancelled();
  if (!WIFEXITED(finished.status) || WEXITSTATUS(finished.status) != 0) {
    throw ToolError(fmt::format("{} {} {}; its last lines:\n{}", program,
                                arguments.empty() ? "" : arguments.front(),
                                HowItEnded(finished.status), LastLines(finished.output, 12)));
  }
  return std::move(finished.output);
}

std::string ToolVersion(const std::string& program) {
  const std::string path = FindProgram(program);
  if (path.empty()) return "missing";
  // COLMAP has no --version. Its help begins with the version.
  const std::string flag = program == "colmap" ? "help" : "--version";
  const Finished finished = RunToEnd(
      path, {flag}, {"QT_QPA_PLATFORM=offscreen"}, [] { return false; }, false);
  // The output of a failed program is not a version. It would become part of fingerprints, and all
  // steps that use the tool would run twice.
  if (!WIFEXITED(finished.status) || WEXITSTATUS(finished.status) != 0)
    throw ToolError(fmt::format(
        "{} {} failed, so its version is not known ({}); its last lines:\n{}\nrepair or reinstall "
        "{}, or run again if the machine was short of memory",
        path, flag, HowItEnded(finished.status), LastLines(finished.output, 6), program));
  std::istringstream lines(finished.output);
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \t\r-") != std::string::npos) return line.substr(0, 200);
  throw ToolError(fmt::format("{} {} prints nothing, so its version is not known; reinstall {}",
                              path, flag, program));
}

}  // namespace keypose
