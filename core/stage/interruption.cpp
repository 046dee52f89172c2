#include "core/stage/interruption.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>

#include "core/values/errors.h"

namespace keypose::internal {
namespace {

std::atomic<bool> g_asked{false}, g_ending{false};
/// Wakes the watching thread: 's' for a signal, 'e' at the end. A handler may do no more than
/// write.
int g_pipe[2] = {-1, -1};

void OnSignal(int) {
  g_asked = true;
  const int before = errno;
  [[maybe_unused]] const ssize_t written = write(g_pipe[1], "s", 1);
  errno = before;
}

void CatchSignals() {
  struct sigaction action {};
  action.sa_handler = OnSignal;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction inherited {};
    // With nohup or a shell's `&`, the signal is ignored on purpose: the program must go on.
    if (sigaction(signal, nullptr, &inherited) == 0 && inherited.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
  signal(SIGPIPE, SIG_IGN);
}

/// @param seconds  negative: without end
/// @return the letter; 0 after that time
char NextLetter(double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (true) {
    const std::chrono::duration<double, std::milli> left = until - std::chrono::steady_clock::now();
    if (seconds >= 0 && left.count() <= 0) return 0;
    pollfd waiting = {g_pipe[0], POLLIN, 0};
    const int wait_ms = seconds < 0 ? -1 : static_cast<int>(left.count()) + 1;
    char letter = 0;
    if (poll(&waiting, 1, wait_ms) > 0 && read(g_pipe[0], &letter, 1) == 1) return letter;
  }
}

}  // namespace

Interruption::Interruption(double grace_s, std::function<bool()> give_up)
    : give_up_(std::move(give_up)) {
  if (pipe2(g_pipe, O_CLOEXEC) != 0) throw DiskError("no pipe can be opened for signals");
  fcntl(g_pipe[1], F_SETFL, O_NONBLOCK);
  // The watcher must not take signals from the thread that would notice them in a system call.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  watcher_ = std::thread([this, grace_s] { Watch(grace_s); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  CatchSignals();
}

void Interruption::Watch(double grace_s) {
  if (NextLetter(-1) == 'e') return;
  if (NextLetter(grace_s) == 'e') return;
  g_ending = true;
  if (give_up_()) _exit(static_cast<int>(ExitCode::kInterrupted));
  g_ending = false;
}

Interruption::~Interruption() {
  while (g_ending) usleep(1000);
  [[maybe_unused]] const ssize_t written = write(g_pipe[1], "e", 1);
  watcher_.join();
  // The handlers stay, and write to a pipe that is gone, which is harmless.
  const int read_end = g_pipe[0], write_end = g_pipe[1];
  g_pipe[0] = g_pipe[1] = -1;
  close(read_end);
  close(write_end);
}

bool Interruption::Asked() { return g_asked; }

}  // namespace keypose::internal
