#include "pipeline/disk/real_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/io/text/shared_files.h"
#include "pipeline/disk/guardian.h"

extern char** environ;

namespace keypose::pipeline {
namespace {

volatile std::sig_atomic_t interrupts = 0;

void OnInterrupt(int) { interrupts = interrupts + 1; }

double SecondsNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The runner's environment with `added` in front. For a name that is added twice, the last value
/// is used.
std::vector<std::string> EnvironmentWith(std::vector<std::string> added) {
  const auto name_of = [](const std::string& text) { return text.substr(0, text.find('=')); };
  std::vector<std::string> result = added;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    if (std::none_of(added.begin(), added.end(),
                     [&](const std::string& a) { return name_of(a) == name_of(text); }))
      result.push_back(text);
  }
  return result;
}

/// A short program whose output is being read.
struct Asked {
  int pid = -1;
  int fds[2] = {-1, -1};  ///< its standard output and error
};

[[noreturn]] void BecomeAsked(const std::vector<std::string>& command, int output, int error) {
  std::vector<char*> arguments;
  for (const std::string& text : command) arguments.push_back(const_cast<char*>(text.c_str()));
  arguments.push_back(nullptr);
  dup2(open("/dev/null", O_RDONLY), 0);
  dup2(output, 1);
  dup2(error, 2);
  execv(arguments[0], arguments.data());
  dprintf(2, "cannot start %s: %s\n", arguments[0], std::strerror(errno));
  _exit(127);
}

Asked StartAsked(const std::vector<std::string>& command) {
  int output[2], error[2];
  if (pipe2(output, O_CLOEXEC) != 0) return {};
  if (pipe2(error, O_CLOEXEC) != 0) return {};
  Asked asked;
  asked.pid = fork();
  if (asked.pid == 0) BecomeAsked(command, output[1], error[1]);
  close(output[1]);
  close(error[1]);
  asked.fds[0] = output[0];
  asked.fds[1] = error[0];
  return asked;
}

/// Reads all available data.
/// @return whether the other end is still open
bool Drain(int fd, std::string* text) {
  char buffer[65536];
  const ssize_t n = read(fd, buffer, sizeof buffer);
  if (n > 0) text->append(buffer, static_cast<std::size_t>(n));
  return n > 0 || (n < 0 && (errno == EINTR || errno == EAGAIN));
}

constexpr std::size_t kMostSaid = 4 << 20;

/// Reads what one of its two outputs has; closes it at its end, and when it says too much.
void HearAsked(Asked& asked, int k, ProcessRunner::Answer& answer) {
  std::string& text = k == 0 ? answer.output : answer.error;
  if (Drain(asked.fds[k], &text) && text.size() <= kMostSaid) return;
  if (text.size() > kMostSaid) {
    answer.error =
        fmt::format("its output exceeds {} MB and does not come to an end", kMostSaid >> 20);
    kill(asked.pid, SIGKILL);
  }
  close(asked.fds[k]);
  asked.fds[k] = -1;
}

/// Waits for its end; one that still has an open output is killed.
/// @return the exit code, or 128 and the signal; 124 when killed here, 127 when it never started
int EndAsked(const Asked& asked) {
  const bool late = asked.fds[0] >= 0 || asked.fds[1] >= 0;
  for (const int fd : asked.fds) {
    if (fd >= 0) close(fd);
  }
  if (asked.pid < 0) return 127;
  if (late) kill(asked.pid, SIGKILL);
  int status = 0;
  waitpid(asked.pid, &status, 0);
  if (late) return 124;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

struct RealProcessRunner::Child {
  Guarded guarded;
  std::string partial_line;
};

RealProcessRunner::RealProcessRunner(bool catch_signals) {
  ::signal(SIGPIPE, SIG_IGN);
  if (!catch_signals) return;
  struct sigaction action {};
  action.sa_handler = OnInterrupt;  // no SA_RESTART: a wait must end at once
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction inherited {};
    // Ignored signals stay ignored: nohup and a shell's `&` set them so that the program goes on.
    if (sigaction(signal, nullptr, &inherited) == 0 && inherited.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
}

RealProcessRunner::~RealProcessRunner() { StopAll(); }

int RealProcessRunner::Start(const Command& command) {
  auto child = std::make_unique<Child>();
  std::vector<std::string> added = command.environment;
  added.push_back("KEYPOSE_PROGRESS_FD=3");
  child->guarded = StartGuarded(command.arguments, EnvironmentWith(added), command.folder,
                                command.log, keep_open_);
  const int id = next_id_++;
  children_[id] = std::move(child);
  return id;
}

void RealProcessRunner::ReadProgress(int id, Child& child, std::vector<ProcessEvent>* events) {
  if (!Drain(child.guarded.progress, &child.partial_line)) {
    close(child.guarded.progress);
    child.guarded.progress = -1;
  }
  for (std::size_t end; (end = child.partial_line.find('\n')) != std::string::npos;
       child.partial_line.erase(0, end + 1)) {
    const auto line = nlohmann::json::parse(child.partial_line.substr(0, end), nullptr, false);
    if (!line.is_object()) continue;  // lines that are not progress are ignored
    ProcessEvent event;
    event.kind = ProcessEvent::Kind::kProgress;
    event.id = id;
    if (line.contains("fraction") && line["fraction"].is_number())
      event.fraction = std::clamp(line["fraction"].get<double>(), 0.0, 1.0);
    if (line.contains("what") && line["what"].is_string())
      event.what = line["what"].get<std::string>();
    events->push_back(event);
  }
}

bool RealProcessRunner::ReadResult(int id, Child& child, std::vector<ProcessEvent>* events) {
  GuardianResult result;
  const ssize_t n = read(child.guarded.result, &result, sizeof result);
  if (n < 0 && errno == EINTR) return false;
  if (n != sizeof result) result = {128 + SIGKILL, 0};  // the guardian itself was killed
  close(child.guarded.control);
  close(child.guarded.result);
  if (child.guarded.progress >= 0) close(child.guarded.progress);
  waitpid(child.guarded.guardian_pid, nullptr, 0);
  ProcessEvent event;
  event.id = id;
  event.exit_code = result.exit_code;
  event.peak_bytes = result.peak_bytes;
  events->push_back(event);
  return true;
}

void RealProcessRunner::PollOnce(int milliseconds, std::vector<ProcessEvent>* events) {
  std::vector<pollfd> fds;
  std::vector<int> ids;
  for (const auto& [id, child] : children_) {
    for (const int fd : {child->guarded.progress, child->guarded.result}) {
      if (fd < 0) continue;
      fds.push_back({fd, POLLIN, 0});
      ids.push_back(id);
    }
  }
  if (poll(fds.data(), fds.size(), milliseconds) <= 0) return;
  for (std::size_t i = 0; i < fds.size(); ++i) {
    if (!fds[i].revents) continue;
    Child& child = *children_.at(ids[i]);
    if (fds[i].fd == child.guarded.progress) {
      ReadProgress(ids[i], child, events);
    } else if (ReadResult(ids[i], child, events)) {
      children_.erase(ids[i]);
    }
  }
}

std::vector<ProcessEvent> RealProcessRunner::Wait(double seconds) {
  std::vector<ProcessEvent> events;
  PollOnce(static_cast<int>(seconds * 1000), &events);
  return events;
}

bool RealProcessRunner::interrupted() const { return interrupts > 0; }

void RealProcessRunner::StopAll() {
  constexpr double kPatienceSeconds = 5;
  const double start = SecondsNow();
  const int interrupts_before = interrupts;
  for (const auto& [id, child] : children_) (void)!write(child->guarded.control, "T", 1);
  std::vector<ProcessEvent> ignored;
  bool killed = false;
  while (!children_.empty()) {
    if (!killed && (SecondsNow() - start > kPatienceSeconds || interrupts > interrupts_before)) {
      for (const auto& [id, child] : children_) (void)!write(child->guarded.control, "K", 1);
      killed = true;
    }
    PollOnce(50, &ignored);
  }
}

std::vector<ProcessRunner::Answer> RealProcessRunner::Ask(
    const std::vector<std::vector<std::string>>& commands) {
  constexpr double kPatienceSeconds = 60;
  std::vector<Asked> asked;
  for (const auto& command : commands) asked.push_back(StartAsked(command));
  std::vector<Answer> answers(commands.size());
  const double start = SecondsNow();
  for (;;) {
    std::vector<pollfd> fds;
    std::vector<std::pair<std::size_t, int>> owners;
    for (std::size_t i = 0; i < asked.size(); ++i) {
      for (int k = 0; k < 2; ++k) {
        if (asked[i].fds[k] < 0) continue;
        fds.push_back({asked[i].fds[k], POLLIN, 0});
        owners.emplace_back(i, k);
      }
    }
    if (fds.empty() || interrupted() || SecondsNow() - start > kPatienceSeconds) break;
    if (poll(fds.data(), fds.size(), 1000) <= 0) continue;
    for (std::size_t n = 0; n < fds.size(); ++n) {
      const auto [i, k] = owners[n];
      if (fds[n].revents) HearAsked(asked[i], k, answers[i]);
    }
  }
  for (std::size_t i = 0; i < asked.size(); ++i) answers[i].exit_code = EndAsked(asked[i]);
  return answers;
}

std::optional<std::filesystem::path> RealProcessRunner::FindTool(const std::string& name) const {
  std::string variable = "KEYPOSE_" + name;
  for (char& c : variable)
    c = std::isalnum(static_cast<unsigned char>(c))
            ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
            : '_';
  if (const char* chosen = std::getenv(variable.c_str()); chosen && *chosen)
    return std::filesystem::path(chosen);
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path candidate = std::filesystem::path(folder) / name;
    if (access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return FindSharedFile(name);
}

}  // namespace keypose::pipeline
