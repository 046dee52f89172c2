// Content hashes of the project's own files, remembered by size, time and inode so that unchanged
// files are not read again.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "pipeline/disk.h"
#include "pipeline/recipe.h"

namespace keypose::pipeline {

/// Whether a file below a folder of the project counts as its content: not what file managers write
/// (names that start with '.', Thumbs.db, desktop.ini).
bool CountsAsContent(const std::string& name);

class ContentHasher {
 public:
  /// @param memory_file  where hashes are remembered
  /// @param root         remembered paths are relative to it, so that a moved project keeps them
  ContentHasher(Disk& disk, std::filesystem::path memory_file, std::filesystem::path root);

  /// Of a file, or of all files below a folder; names that start with '.', and Thumbs.db and
  /// desktop.ini, do not count, since file managers write them. @pre path exists
  Content Of(const std::filesystem::path& path);
  /// Hash of one file.
  std::string OfFile(const std::filesystem::path& path);
  /// @param cancelled  asked before each file that must be read; true makes that throw Cancelled
  void SetCancel(std::function<bool()> cancelled) { cancelled_ = std::move(cancelled); }
  /// Writes what was learnt, if anything and if the disk lets it.
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
