#include "studio/runs/children.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "core/errors.h"

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

/// In the new process: a session of its own, so that Ctrl-C on the studio does not reach it twice.
[[noreturn]] void Become(const std::vector<char*>& words, const char* folder, int out, int error) {
  setsid();
  const int nothing = open("/dev/null", O_RDONLY);
  if (chdir(folder) != 0 || dup2(nothing, 0) < 0 || dup2(out, 1) < 0 || dup2(error, 2) < 0)
    _exit(126);
  execv(words[0], words.data());
  _exit(127);
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

fs::path OwnFolder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

ChildResult RunChild(const std::vector<std::string>& arguments, const fs::path& folder,
                     double seconds) {
  int pipe_ends[2];
  if (pipe2(pipe_ends, O_CLOEXEC) != 0)
    throw DiskError(std::string("cannot make a pipe: ") + std::strerror(errno));
  const std::vector<char*> words = Words(arguments);
  const std::string where = folder.string();
  const pid_t pid = fork();
  if (pid == 0) Become(words, where.c_str(), pipe_ends[1], pipe_ends[1]);
  close(pipe_ends[1]);
  if (pid < 0) {
    close(pipe_ends[0]);
    throw DiskError(std::string("cannot start a program: ") + std::strerror(errno));
  }
  ChildResult result;
  const bool ended = ReadAll(pipe_ends[0], seconds, &result.output);
  close(pipe_ends[0]);
  if (!ended) kill(-pid, SIGTERM);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  result.exit_code = !ended              ? 124
                     : WIFEXITED(status) ? WEXITSTATUS(status)
                                         : 128 + WTERMSIG(status);
  return result;
}

int StartChild(const std::vector<std::string>& arguments, const fs::path& folder,
               const fs::path& output, const fs::path& error) {
  const int out = OpenToWrite(output), err = OpenToWrite(error);
  const std::vector<char*> words = Words(arguments);
  const std::string where = folder.string();
  const pid_t pid = fork();
  if (pid == 0) Become(words, where.c_str(), out, err);
  close(out);
  close(err);
  if (pid < 0) throw DiskError(std::string("cannot start a program: ") + std::strerror(errno));
  return pid;
}

}  // namespace keypose::studio
