// A disk in memory, with settable times.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>

#include "pipeline/disk/clock.h"
#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

class MemoryDisk final : public Disk {
 public:
  std::optional<FileStat> Stat(const Path& path) const override;
  bool LeadsOutside(const Path&, const Path&) const override { return false; }
  std::vector<std::string> FilesBelow(const Path& folder) const override;
  std::vector<std::string> Children(const Path& folder) const override;
  std::string Read(const Path& path) const override;
  std::string ReadEnd(const Path& path, std::size_t most) const override;
  std::string ContentHash(const Path& path) const override;
  void Write(const Path& path, std::string_view text) override;
  void MakeFolder(const Path& path) override;
  void Move(const Path& from, const Path& to) override;
  void Copy(const Path& from, const Path& to) override;
  void Remove(const Path& path) override;
  void Sync(const Path&) override {}

  /// Stands for another program that is at work while a file is copied; may be empty.
  std::function<void(const Path& from)> before_copy;
  /// Gives a file a new time with the same content.
  void Touch(const Path& path);
  /// Simulates bit rot: flips a bit and leaves size and times unchanged.
  void Rot(const Path& path);
  /// If true, every write from now on fails as on a full disk.
  void SetFull(bool full) { full_ = full; }
  int hashed() const { return hashed_; }  ///< number of files read for hashing

 private:
  struct File {
    std::string text;
    std::int64_t mtime_ns = 0;
    std::uint64_t inode = 0;
  };
  void CheckSpace(const Path& path) const;
  std::map<std::string, File> files_;
  std::set<std::string> folders_;
  std::int64_t time_ns_ = 1000;
  std::uint64_t next_inode_ = 1;
  bool full_ = false;
  mutable int hashed_ = 0;
};

class FakeClock final : public Clock {
 public:
  double Now() const override { return now_; }
  void Advance(double seconds) { now_ += seconds; }

 private:
  double now_ = 1.7e9;
};

}  // namespace keypose::pipeline
