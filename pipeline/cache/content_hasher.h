// Content hashes of the project's own files. They are remembered with size, times and inode, so
// that unchanged files are not read again.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "pipeline/cache/fingerprint.h"
#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

/// Whether a file below a project folder counts as its content. Files that file managers write
/// (names that start with '.', Thumbs.db, desktop.ini) do not.
bool CountsAsContent(const std::string& name);

class ContentHasher {
 public:
  /// @param memory_file  file in which hashes are stored
  /// @param root         stored paths are relative to it, so that they stay valid when the project
  /// is moved
  ContentHasher(Disk& disk, std::filesystem::path memory_file, std::filesystem::path root);

  /// Content of a file, or of all files below a folder for which CountsAsContent holds. @pre path
  /// exists
  Content Of(const std::filesystem::path& path);
  /// Hash of one file.
  std::string OfFile(const std::filesystem::path& path);
  /// @param cancelled  called before each file is read; if it returns true, Cancelled is thrown
  void SetCancel(std::function<bool()> cancelled) { cancelled_ = std::move(cancelled); }
  /// Writes new hashes, if there are any; write errors are ignored.
  void Save();
  int files_read() const { return files_read_; }

 private:
  struct Entry {
    FileStat stat;
    std::string hash;
  };
  void Load();
  std::string Read(const std::filesystem::path& path, const std::string& key);

  Disk& disk_;
  std::filesystem::path memory_file_, root_;
  std::function<bool()> cancelled_;
  std::map<std::string, Entry> entries_;
  bool loaded_ = false, changed_ = false;
  int files_read_ = 0;
};

}  // namespace keypose::pipeline
