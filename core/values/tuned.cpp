#include "core/values/tuned.h"

#ifdef KEYPOSE_SENSITIVITY

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace keypose {
namespace {

constexpr int kMostConstants = 4096;
constexpr std::size_t kPageBytes = 4096;

/// Which constants a program reads is seen by the processor: each stands in a page of its own that
/// may not be read, and the signal of the first attempt notes the name and opens the page. The
/// constants stay plain numbers for the code.
struct ReadLog {
  char* pages = nullptr;  ///< kMostConstants pages
  int used = 0;
  int file = -1;                         ///< of KEYPOSE_TUNED_READ
  char names[kMostConstants][160] = {};  ///< "FILE:NAME\n" by page
  struct sigaction before = {};
};

ReadLog& Log() {
  static ReadLog log;
  return log;
}

void NoteRead(int, siginfo_t* info, void*) {
  ReadLog& log = Log();
  const auto offset = static_cast<std::ptrdiff_t>(reinterpret_cast<std::uintptr_t>(info->si_addr) -
                                                  reinterpret_cast<std::uintptr_t>(log.pages));
  const auto page = offset / static_cast<std::ptrdiff_t>(kPageBytes);
  if (offset < 0 || page >= log.used) {
    // A fault of the program itself: it happens again, and ends the program as without us.
    sigaction(SIGSEGV, &log.before, nullptr);
    return;
  }
  mprotect(log.pages + page * kPageBytes, kPageBytes, PROT_READ);
  const char* name = log.names[page];
  if (write(log.file, name, std::strlen(name)) < 0) _exit(70);
}

void Start(ReadLog& log) {
  void* pages = mmap(nullptr, kMostConstants * kPageBytes, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED) std::abort();
  log.pages = static_cast<char*>(pages);
  const char* path = std::getenv("KEYPOSE_TUNED_READ");
  if (path == nullptr) return;
  log.file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log.file < 0) std::abort();
  struct sigaction action = {};
  action.sa_sigaction = NoteRead;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSEGV, &action, &log.before);
}

}  // namespace

double TunedValue(const char* file, const char* name, double value) {
  const char* setting = std::getenv("KEYPOSE_TUNED");
  if (setting == nullptr) return value;
  const std::string text = setting;
  const auto equals = text.find('=');
  const auto colon = text.find(':');
  if (equals == std::string::npos || colon == std::string::npos) return value;
  const bool this_one = std::string(file).ends_with(text.substr(0, colon)) &&
                        text.substr(colon + 1, equals - colon - 1) == name;
  if (!this_one) return value;
  std::fprintf(stderr, "tuned: %s = %s\n", name, text.c_str() + equals + 1);
  return std::strtod(text.c_str() + equals + 1, nullptr);
}

void* TunedPage() {
  ReadLog& log = Log();
  if (log.pages == nullptr) Start(log);
  if (log.used == kMostConstants) std::abort();
  return log.pages + kPageBytes * static_cast<std::size_t>(log.used++);
}

void PublishTuned(void* page, const char* file, const char* name) {
  ReadLog& log = Log();
  const auto number =
      (static_cast<char*>(page) - log.pages) / static_cast<std::ptrdiff_t>(kPageBytes);
  std::snprintf(log.names[number], sizeof log.names[number], "%s:%s\n", file, name);
  mprotect(page, kPageBytes, log.file < 0 ? PROT_READ : PROT_NONE);
}

}  // namespace keypose

#endif
