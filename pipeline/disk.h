// What the runner asks of a file system, so that the rebuild rules can be tested without one.
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
  std::int64_t ctime_ns = 0;  ///< when content, name or attributes changed last; programs can set
                              ///< mtime back, but not this
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
  /// Whether links on the way to a path, which need not exist, lead out of a folder.
  virtual bool LeadsOutside(const Path& path, const Path& folder) const = 0;
  /// Names of all files (not folders, pipes or devices) below a folder, relative, with '/', sorted
  /// by bytes. A missing folder has none. Links to folders are followed, each folder once.
  virtual std::vector<std::string> FilesBelow(const Path& folder) const = 0;
  /// Names of the entries right in a folder, sorted. A missing folder has none.
  virtual std::vector<std::string> Children(const Path& folder) const = 0;
  virtual std::string Read(const Path& path) const = 0;
  /// The last bytes of a file, at most so many: a log may be larger than the memory.
  virtual std::string ReadEnd(const Path& path, std::size_t most) const = 0;
  /// SHA-256 of a file's content, 64 hexadecimal digits.
  virtual std::string ContentHash(const Path& path) const = 0;

  /// Replaces a file as a whole, or not at all, also when the power fails; makes its folder.
  virtual void Write(const Path& path, std::string_view text) = 0;
  virtual void MakeFolder(const Path& path) = 0;
  /// Renames a file or a folder; an existing target is replaced in one step where the file system
  /// can.
  virtual void Move(const Path& from, const Path& to) = 0;
  /// Copies one file (sharing blocks where the file system can); the target appears whole, and its
  /// folder is made.
  virtual void Copy(const Path& from, const Path& to) = 0;
  /// Removes a file or a whole folder; missing is fine.
  virtual void Remove(const Path& path) = 0;
  /// Everything below a folder reaches the device before this returns.
  virtual void Sync(const Path& folder) = 0;
};

}  // namespace keypose::pipeline
