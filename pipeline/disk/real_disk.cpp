#include "pipeline/disk/real_disk.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <set>
#include <utility>

#include "core/numbers/sha256.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailOnDisk(const std::string& what, const fs::path& path, int error) {
  std::string message = "cannot " + what + " " + path.string() + ": " + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT)
    message +=
        "; free some space (`keypose gc` removes old results) and run again: nothing finished is "
        "lost";
  throw DiskError(message);
}

class Fd {
 public:
  explicit Fd(int fd) : fd_(fd) {}
  ~Fd() {
    if (fd_ >= 0) close(fd_);
  }
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  int get() const { return fd_; }
  /// Closing may report write errors.
  int Close() {
    const int fd = fd_;
    fd_ = -1;
    return close(fd);
  }

 private:
  int fd_;
};

void WriteAll(int fd, const char* data, std::size_t size, const fs::path& path) {
  while (size > 0) {
    const ssize_t n = write(fd, data, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) FailOnDisk("write", path, errno);
    data += n;
    size -= static_cast<std::size_t>(n);
  }
}

template <class Consume>
void ReadAll(const fs::path& path, const Consume& consume) {
  // Non-blocking: opening a pipe would wait for a writer.
  Fd fd(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (fd.get() < 0) FailOnDisk("read", path, errno);
  struct stat info;
  if (fstat(fd.get(), &info) != 0) FailOnDisk("read", path, errno);
  if (!S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode))
    throw DiskError(path.string() + " is a pipe or a device, but a file is needed");
  std::vector<char> buffer(1 << 18);
  for (;;) {
    const ssize_t n = read(fd.get(), buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) FailOnDisk("read", path, errno);
    if (n == 0) return;
    consume(buffer.data(), static_cast<std::size_t>(n));
  }
}

/// Copies one open file to another, sharing blocks where the file system can (btrfs, XFS).
void CopyContent(int from, int to, const fs::path& from_path, const fs::path& to_path) {
  if (ioctl(to, FICLONE, from) == 0) return;
  std::vector<char> buffer(1 << 18);
  for (;;) {
    const ssize_t n = read(from, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) FailOnDisk("read", from_path, errno);
    if (n == 0) return;
    WriteAll(to, buffer.data(), static_cast<std::size_t>(n), to_path);
  }
}

/// Links to folders are followed, each folder once. Links to a parent folder are not followed: that
/// would never end. Pipes and devices are left out, as in all readers of photographs.
void AddFilesBelow(const fs::path& folder, const std::string& prefix,
                   std::set<std::pair<dev_t, ino_t>>* seen, std::vector<std::string>* names) {
  struct stat info;
  if (stat(folder.c_str(), &info) != 0) {
    if (errno == ENOENT) return;
    FailOnDisk("list", folder, errno);
  }
  if (!S_ISDIR(info.st_mode) || !seen->insert({info.st_dev, info.st_ino}).second) return;
  std::vector<std::string> children;
  std::error_code error;
  for (fs::directory_iterator it(folder, error); !error && it != fs::directory_iterator();
       it.increment(error))
    children.push_back(it->path().filename().string());
  if (error) FailOnDisk("list", folder, error.value());
  // Sorted, so that of two links to one folder always the same one is followed.
  std::sort(children.begin(), children.end());
  for (const std::string& name : children) {
    const fs::path path = folder / name;
    // A broken link is listed; reading it gives the error message.
    if (stat(path.c_str(), &info) != 0 || S_ISREG(info.st_mode))
      names->push_back(prefix + name);
    else if (S_ISDIR(info.st_mode))
      AddFilesBelow(path, prefix + name + "/", seen, names);
  }
}

}  // namespace

std::optional<FileStat> RealDisk::Stat(const Path& path) const {
  struct stat info;
  if (stat(path.c_str(), &info) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
    FailOnDisk("look at", path, errno);
  }
  FileStat result;
  result.folder = S_ISDIR(info.st_mode);
  result.size = static_cast<std::uint64_t>(info.st_size);
  result.mtime_ns =
      static_cast<std::int64_t>(info.st_mtim.tv_sec) * 1000000000 + info.st_mtim.tv_nsec;
  result.inode = info.st_ino;
  result.ctime_ns =
      static_cast<std::int64_t>(info.st_ctim.tv_sec) * 1000000000 + info.st_ctim.tv_nsec;
  return result;
}

bool RealDisk::LeadsOutside(const Path& path, const Path& folder) const {
  std::error_code error;
  const Path inner = fs::weakly_canonical(path, error), outer = fs::weakly_canonical(folder, error);
  return error || !IsWithin(inner, outer);
}

std::vector<std::string> RealDisk::FilesBelow(const Path& folder) const {
  std::vector<std::string> names;
  std::set<std::pair<dev_t, ino_t>> seen;
  std::error_code error;
  const Path resolved = fs::weakly_canonical(folder, error);
  for (Path above = resolved.parent_path();
       !error && !above.empty() && above != above.parent_path(); above = above.parent_path()) {
    struct stat info;
    if (stat(above.c_str(), &info) == 0) seen.insert({info.st_dev, info.st_ino});
  }
  AddFilesBelow(folder, "", &seen, &names);
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> RealDisk::Children(const Path& folder) const {
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator it(folder, error);
  if (error == std::errc::no_such_file_or_directory) return names;
  for (; !error && it != fs::directory_iterator(); it.increment(error))
    names.push_back(it->path().filename().string());
  if (error) FailOnDisk("list", folder, error.value());
  std::sort(names.begin(), names.end());
  return names;
}

std::string RealDisk::Read(const Path& path) const {
  std::string text;
  ReadAll(path, [&](const char* data, std::size_t size) { text.append(data, size); });
  return text;
}

std::string RealDisk::ReadEnd(const Path& path, std::size_t most) const {
  Fd fd(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (fd.get() < 0) FailOnDisk("read", path, errno);
  const off_t size = lseek(fd.get(), 0, SEEK_END);
  if (size < 0) FailOnDisk("read", path, errno);
  std::string text(std::min(most, static_cast<std::size_t>(size)), 0);
  const ssize_t got =
      pread(fd.get(), text.data(), text.size(), size - static_cast<off_t>(text.size()));
  if (got < 0) FailOnDisk("read", path, errno);
  text.resize(static_cast<std::size_t>(got));
  return text;
}

std::string RealDisk::ContentHash(const Path& path) const {
  Sha256 hash;
  ReadAll(path, [&](const char* data, std::size_t size) { hash.Add({data, size}); });
  return hash.Hex();
}

/// Fills a temporary file and renames it to the target. Another run may clear the staging folder in
/// the meantime, or the folder may lie on another file system than the target; then the temporary
/// file is created beside the target.
template <class Fill>
void RealDisk::Place(const Path& target, const Fill& fill) const {
  static std::atomic<int> counter = 0;
  const std::string name = target.filename().string() + ".tmp" + std::to_string(getpid()) + "-" +
                           std::to_string(counter++);
  std::error_code ignored;
  if (target.has_parent_path()) const_cast<RealDisk*>(this)->MakeFolder(target.parent_path());
  for (const bool staged : {true, false}) {
    if (staged && staging_.empty()) continue;
    if (staged) fs::create_directories(staging_, ignored);
    const Path temporary = (staged ? staging_ : target.parent_path()) / name;
    Fd fd(open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (fd.get() < 0 && staged) continue;
    if (fd.get() < 0) FailOnDisk("write", target, errno);
    try {
      fill(fd.get());
      if (fd.Close() != 0) FailOnDisk("write", target, errno);
    } catch (...) {
      unlink(temporary.c_str());
      throw;
    }
    if (rename(temporary.c_str(), target.c_str()) == 0) return;
    const int error = errno;
    unlink(temporary.c_str());
    if (!staged || (error != EXDEV && error != ENOENT)) FailOnDisk("write", target, error);
  }
}

void RealDisk::Write(const Path& path, std::string_view text) {
  Place(path, [&](int fd) {
    WriteAll(fd, text.data(), text.size(), path);
    // Synced before the rename: after a power cut, some file systems would have the new name
    // without the new content.
    if (fdatasync(fd) != 0 && errno != EINVAL && errno != ENOSYS) FailOnDisk("write", path, errno);
  });
}

void RealDisk::MakeFolder(const Path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) FailOnDisk("make the folder", path, error.value());
}

void RealDisk::Move(const Path& from, const Path& to) {
  if (to.has_parent_path()) MakeFolder(to.parent_path());
  if (rename(from.c_str(), to.c_str()) == 0) return;
  if (errno != ENOTEMPTY && errno != EEXIST && errno != EISDIR && errno != ENOTDIR)
    FailOnDisk("move into place", to, errno);
  // The target is a folder: swap the two in one step, so that the target exists at all times.
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0)
    return Remove(from);
  Remove(to);
  if (rename(from.c_str(), to.c_str()) != 0) FailOnDisk("move into place", to, errno);
}

void RealDisk::Copy(const Path& from, const Path& to) {
  Fd source(open(from.c_str(), O_RDONLY | O_CLOEXEC));
  if (source.get() < 0) FailOnDisk("read", from, errno);
  Place(to, [&](int fd) {
    if (lseek(source.get(), 0, SEEK_SET) != 0) FailOnDisk("read", from, errno);
    CopyContent(source.get(), fd, from, to);
  });
}

void RealDisk::Remove(const Path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error && error != std::errc::no_such_file_or_directory)
    FailOnDisk("remove", path, error.value());
}

void RealDisk::Sync(const Path& folder) {
  Fd fd(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() < 0) FailOnDisk("open", folder, errno);
  if (syncfs(fd.get()) != 0 && errno != EINVAL && errno != ENOSYS)
    FailOnDisk("write", folder, errno);
}

}  // namespace keypose::pipeline
