// Writes a ZIP file (libarchive).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace keypose::pipeline {

/// A ZIP file that appears under its name when it is complete, and never otherwise: until Finish()
/// it has no name at all where the file system can do that (else NAME.part), so that nothing is
/// left of one that was interrupted.
class ZipWriter {
 public:
  /// @throws DiskError  a file of that name exists, or none can be written there
  explicit ZipWriter(const std::filesystem::path& file);
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  /// Adds the content of one file, with its time and whether it can be executed.
  /// @param name  in the archive, with '/'; UTF-8
  /// @throws DiskError  it cannot be read, it got shorter meanwhile, or the disk is full
  void Add(const std::filesystem::path& from, const std::string& name);
  /// @return size of the finished file [bytes]
  /// @throws DiskError  the disk is full, or the name was taken meanwhile
  std::uint64_t Finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace keypose::pipeline
