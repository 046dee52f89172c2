#include "pipeline/cache/project_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "pipeline/cache/records.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

struct Holder {
  int pid = 0;
  std::string host, since, what;
  bool known() const { return pid > 0; }
  std::string Text() const {
    return known() ? fmt::format("process {} on {}, since {} ({})", pid, host, since, what)
                   : "a process that has not written its name yet";
  }
};

std::string HostName() {
  char name[256] = {};
  gethostname(name, sizeof name - 1);
  return name;
}

Holder ReadHolder(int fd) {
  char text[4096];
  const ssize_t n = pread(fd, text, sizeof text, 0);
  const auto value = nlohmann::json::parse(
      n > 0 ? std::string(text, static_cast<std::size_t>(n)) : "", nullptr, false);
  try {
    return {value.at("pid").get<int>(), value.at("host").get<std::string>(),
            value.at("since").get<std::string>(), value.at("what").get<std::string>()};
  } catch (const nlohmann::json::exception&) {
    return {};  // nothing written yet, or damaged: only flock shows whether it is held
  }
}

bool IsDead(const Holder& holder) {
  return holder.known() && holder.host == HostName() && kill(holder.pid, 0) != 0 && errno == ESRCH;
}

int OpenLock(const fs::path& file) {
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) throw DiskError("cannot write " + file.string() + ": " + std::strerror(errno));
  return fd;
}

/// Whether the open file still has that name (`unlock --force` removes the name).
bool StillNamed(int fd, const fs::path& file) {
  struct stat opened, named;
  return fstat(fd, &opened) == 0 && stat(file.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

}  // namespace

ProjectLock::ProjectLock(const fs::path& state_folder, const std::string& what)
    : file_(state_folder / "lock") {
  constexpr int kTries = 100;  // 5 s in all; used only if the holder is dead and its last children
                               // are still being stopped
  std::error_code error;
  fs::create_directories(state_folder, error);
  if (error)
    throw DiskError("cannot make the folder " + state_folder.string() + ": " + error.message());
  for (int i = 0;; ++i) {
    fd_ = OpenLock(file_);
    const bool locked = flock(fd_, LOCK_EX | LOCK_NB) == 0;
    const int reason = errno;
    if (locked && StillNamed(fd_, file_)) break;
    const Holder holder = ReadHolder(fd_);
    close(fd_);
    fd_ = -1;
    if (!locked && reason != EWOULDBLOCK)
      throw DiskError(fmt::format("cannot lock {}: {}", file_.string(), std::strerror(reason)));
    if (locked || (i < kTries && IsDead(holder))) {
      usleep(50000);
      continue;
    }
    throw LockedError(fmt::format(
        "the project is in use by {}; wait until it is done, stop it, or see `keypose unlock`",
        holder.Text()));
  }
  const std::string text = nlohmann::json{
      {"pid", getpid()},
      {"host", HostName()},
      {"since", TimeText(static_cast<double>(std::time(nullptr)))},
      {"what", what}}.dump();
  if (ftruncate(fd_, 0) != 0 ||
      pwrite(fd_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
    const int reason = errno;
    close(fd_);
    throw DiskError("cannot write " + file_.string() + ": " + std::strerror(reason));
  }
}

ProjectLock::~ProjectLock() {
  (void)!ftruncate(fd_, 0);
  close(fd_);
}

std::string LockHolder(const fs::path& state_folder) {
  const int fd = open((state_folder / "lock").c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return "";
  const Holder holder = ReadHolder(fd);
  close(fd);
  return holder.known() && !IsDead(holder) ? holder.Text() : "";
}

std::string Unlock(const fs::path& state_folder, bool force) {
  const fs::path file = state_folder / "lock";
  if (!fs::exists(file)) return "the project is not locked";
  const int fd = OpenLock(file);
  const Holder holder = ReadHolder(fd);
  if (flock(fd, LOCK_EX | LOCK_NB) == 0) {
    (void)!ftruncate(fd, 0);
    close(fd);
    return holder.known()
               ? fmt::format("{} has ended without clearing its lock; cleared", holder.Text())
               : "the project is not locked";
  }
  close(fd);
  if (!force) {
    const bool here = holder.host == HostName();
    throw LockedError(fmt::format(
        "the project is in use by {}; {}", holder.Text(),
        here ? fmt::format("stop it with `kill {}`", holder.pid)
             : "if that machine no longer exists, `keypose unlock --force` removes the lock"));
  }
  fs::remove(file);
  return fmt::format(
      "removed the lock of {}; if that process still runs, stop it before the next run",
      holder.Text());
}

}  // namespace keypose::pipeline
