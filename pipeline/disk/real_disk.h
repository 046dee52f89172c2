// The machine's file system.
#pragma once

#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

class RealDisk final : public Disk {
 public:
  /// @param staging  folder in which files are written before they are renamed into place, so that
  /// a killed run leaves no partial file among others; empty: the target's own folder
  explicit RealDisk(Path staging = {}) : staging_(std::move(staging)) {}

  std::optional<FileStat> Stat(const Path& path) const override;
  bool LeadsOutside(const Path& path, const Path& folder) const override;
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
  void Sync(const Path& folder) override;

 private:
  template <class Fill>
  void Place(const Path& target, const Fill& fill) const;
  Path staging_;
};

}  // namespace keypose::pipeline
