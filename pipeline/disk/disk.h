// The runner's interface to the file system, so that the rebuild rules can be tested without one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace keypose::pipeline {

struct FileStat {
  bool folder = false;
  std::uint64_t size = 0;
  std::int64_t mtime_ns = 0;
  std::uint64_t inode = 0;
  /// last change of content, name or attributes; unlike mtime, programs cannot set it back
  std::int64_t ctime_ns = 0;
  bool operator==(const FileStat&) const = default;
};

/// Paths are absolute or relative to the process. Every function throws DiskError with the path and
/// the system's reason.
class Disk {
 public:
  using Path = std::filesystem::path;
  virtual ~Disk() = default;

  /// Follows links; nothing when the path does not exist.
  virtual std::optional<FileStat> Stat(const Path& path) const = 0;
  /// Whether links on the way to a path lead out of a folder. The path need not exist.
  virtual bool LeadsOutside(const Path& path, const Path& folder) const = 0;
  /// Names of all files (not folders, pipes or devices) below a folder, relative, with '/', sorted
  /// by bytes. A missing folder has none. Links to folders are followed, each folder once.
  virtual std::vector<std::string> FilesBelow(const Path& folder) const = 0;
  /// Names of a folder's direct entries, sorted. A missing folder has none.
  virtual std::vector<std::string> Children(const Path& folder) const = 0;
  virtual std::string Read(const Path& path) const = 0;
  /// The last bytes of a file, at most `most`: a log may be larger than the memory.
  virtual std::string ReadEnd(const Path& path, std::size_t most) const = 0;
  /// SHA-256 of a file's content, 64 hexadecimal digits.
  virtual std::string ContentHash(const Path& path) const = 0;

  /// Replaces a file completely or not at all, even in a power failure. Creates its folder.
  virtual void Write(const Path& path, std::string_view text) = 0;
  virtual void MakeFolder(const Path& path) = 0;
  /// Renames a file or a folder; an existing target is replaced in one step where the file system
  /// can.
  virtual void Move(const Path& from, const Path& to) = 0;
  /// Copies one file (sharing blocks where the file system can). The target appears only when
  /// complete. Creates its folder.
  virtual void Copy(const Path& from, const Path& to) = 0;
  /// Removes a file or a whole folder. A missing path is no error.
  virtual void Remove(const Path& path) = 0;
  /// Returns when everything below a folder has reached the device.
  virtual void Sync(const Path& folder) = 0;
};

}  // namespace keypose::pipeline
