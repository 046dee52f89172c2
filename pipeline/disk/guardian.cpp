#include "pipeline/disk/guardian.h"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/values/errors.h"

namespace keypose::pipeline {
namespace {

// The guardian's descriptors, after all others were closed.
constexpr int kProgress = 3, kResult = 4, kControl = 5, kKeep = 6;

struct Prepared {
  std::vector<char*> arguments, environment;
  std::string folder;
  int log = -1, progress = -1, result = -1, control = -1, keep = -1;
};

std::vector<char*> Pointers(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

/// Keeps only the descriptors that the guardian needs. An inherited end of another guardian's
/// control pipe would prevent that guardian from noticing that the runner died.
void ArrangeDescriptors(const Prepared& prepared) {
  const std::array<int, 5> high = {
      fcntl(prepared.log, F_DUPFD, 100), fcntl(prepared.progress, F_DUPFD, 100),
      fcntl(prepared.result, F_DUPFD, 100), fcntl(prepared.control, F_DUPFD, 100),
      prepared.keep >= 0 ? fcntl(prepared.keep, F_DUPFD, 100) : -1};
  const int null = open("/dev/null", O_RDONLY);
  dup2(null, 0);
  dup2(high[0], 1);
  dup2(high[0], 2);
  dup2(high[1], kProgress);
  dup2(high[2], kResult);
  dup2(high[3], kControl);
  if (high[4] >= 0) dup3(high[4], kKeep, O_CLOEXEC);
  close_range(high[4] >= 0 ? kKeep + 1 : kKeep, ~0U, 0);
}

[[noreturn]] void BecomeStage(const Prepared& prepared) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  close(kResult);
  close(kControl);
  close(kKeep);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) ::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (chdir(prepared.folder.c_str()) == 0)
    execve(prepared.arguments[0], prepared.arguments.data(), prepared.environment.data());
  dprintf(2, "cannot start %s: %s\n", prepared.arguments[0], std::strerror(errno));
  _exit(127);
}

int ParentOf(const char* pid_text) {
  char path[64], line[512];
  std::snprintf(path, sizeof path, "/proc/%.20s/stat", pid_text);
  const int fd = open(path, O_RDONLY);
  if (fd < 0) return -1;
  const ssize_t n = read(fd, line, sizeof line - 1);
  close(fd);
  if (n <= 0) return -1;
  line[n] = 0;
  const char* close_bracket = std::strrchr(line, ')');
  int parent = -1;
  char state = 0;
  if (!close_bracket || std::sscanf(close_bracket + 1, " %c %d", &state, &parent) != 2) return -1;
  return parent;
}

/// Kills the group (0: none) and all orphans that the guardian adopted, until none is left.
void KillAll(int group) {
  for (int round = 0; round < 2000; ++round) {
    if (group > 0) kill(-group, SIGKILL);
    if (DIR* processes = opendir("/proc")) {
      while (const dirent* entry = readdir(processes)) {
        const int pid = std::atoi(entry->d_name);
        if (pid > 1 && ParentOf(entry->d_name) == getpid()) kill(pid, SIGKILL);
      }
      closedir(processes);
    }
    for (;;) {
      const int pid = waitpid(-1, nullptr, WNOHANG);
      if (pid < 0 && errno == ECHILD) return;
      if (pid <= 0) break;
    }
    usleep(2000);
  }
}

/// Reaps ended children.
/// @return whether the stage was among them
bool Reap(int stage, int* status) {
  bool ended = false;
  for (;;) {
    int one = 0;
    const int pid = waitpid(-1, &one, WNOHANG);
    if (pid <= 0) return ended;
    if (pid == stage) {
      *status = one;
      ended = true;
    }
  }
}

/// Passes on requests until the stage ends.
/// @return false if it was killed because the runner died
bool Watch(int stage, int children_fd, int* status) {
  for (;;) {
    pollfd fds[2] = {{kControl, POLLIN, 0}, {children_fd, POLLIN, 0}};
    if (poll(fds, 2, -1) < 0) continue;
    if (fds[1].revents) {
      signalfd_siginfo info;
      (void)!read(children_fd, &info, sizeof info);
      if (Reap(stage, status)) return true;
    }
    if (fds[0].revents) {
      char request = 0;
      if (read(kControl, &request, 1) <= 0) return false;
      kill(-stage, request == 'T' ? SIGTERM : SIGKILL);
    }
  }
}

[[noreturn]] void BecomeInner(const Prepared& prepared) {
  setpgid(0, 0);
  prctl(PR_SET_NAME, "kp-guardian");
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  sigset_t child_signal;
  sigemptyset(&child_signal);
  sigaddset(&child_signal, SIGCHLD);
  sigprocmask(SIG_SETMASK, &child_signal, nullptr);
  const int children_fd = signalfd(-1, &child_signal, SFD_CLOEXEC);
  const int stage = fork();
  if (stage == 0) BecomeStage(prepared);
  int status = 127 << 8;
  if (stage > 0) {
    setpgid(stage, stage);
    close(kProgress);
    Watch(stage, children_fd, &status);
    KillAll(stage);
  }
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  GuardianResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.peak_bytes = static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
  (void)!write(kResult, &result, sizeof result);
  _exit(0);
}

/// The guardian's guardian. With only one guardian, killing it together with the runner would leave
/// the stage's processes running. Its process name differs from the runner's, so that `killall
/// keypose` does not kill it.
[[noreturn]] void BecomeOuter(const Prepared& prepared) {
  setpgid(0, 0);
  ArrangeDescriptors(prepared);
  prctl(PR_SET_NAME, "kp-watcher");
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(signal, SIG_IGN);
  ::signal(SIGCHLD, SIG_DFL);
  const int inner = fork();
  if (inner == 0) BecomeInner(prepared);
  close(kProgress);
  int status = 127 << 8;
  while (inner > 0 && waitpid(inner, &status, 0) < 0 && errno == EINTR) {
  }
  const bool did_its_work = inner > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (!did_its_work) {
    KillAll(0);
    const GuardianResult killed{128 + SIGKILL, 0};
    (void)!write(kResult, &killed, sizeof killed);
  }
  _exit(0);
}

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw ToolError(std::string("cannot make a pipe: ") + std::strerror(errno));
    read = ends[0];
    write = ends[1];
  }
};

}  // namespace

Guarded StartGuarded(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& environment, const std::string& folder,
                     const std::string& log, int keep_open) {
  Prepared prepared{Pointers(arguments), Pointers(environment), folder};
  prepared.keep = keep_open;
  prepared.log = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0666);
  if (prepared.log < 0) throw DiskError("cannot write " + log + ": " + std::strerror(errno));
  const Pipe control, progress, result;
  prepared.progress = progress.write;
  prepared.result = result.write;
  prepared.control = control.read;
  const int pid = fork();
  if (pid == 0) {
    close(control.write);
    BecomeOuter(prepared);
  }
  const int error = errno;
  for (const int fd : {prepared.log, progress.write, result.write, control.read}) close(fd);
  if (pid < 0) {
    for (const int fd : {progress.read, result.read, control.write}) close(fd);
    throw ToolError(std::string("cannot start another process: ") + std::strerror(error));
  }
  fcntl(progress.read, F_SETFL, O_NONBLOCK);
  return {pid, control.write, progress.read, result.read};
}

}  // namespace keypose::pipeline
