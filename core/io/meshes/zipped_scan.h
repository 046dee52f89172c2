// ZIP files of scanning apps, unpacked into a folder of their own for as long as they are read.
#pragma once

#include <filesystem>

namespace keypose {

class ZippedScan {
 public:
  /// Unpacks everything into a new folder below the system's for temporary files.
  /// @throws DiskError   cannot be read; no room
  /// @throws InputError  damaged; names that lead out of the folder; more than kMostBytes or
  ///                     kMostFiles; no mesh that is read, or several
  explicit ZippedScan(const std::filesystem::path& path);
  ZippedScan(const ZippedScan&) = delete;
  ZippedScan& operator=(const ZippedScan&) = delete;
  /// Removes the folder.
  ~ZippedScan();

  static constexpr long long kMostBytes = 4LL << 30;
  static constexpr int kMostFiles = 10000;

  /// The mesh among the files: glTF, else OBJ, PLY, STL or OFF.
  const std::filesystem::path& mesh() const { return mesh_; }

 private:
  std::filesystem::path folder_, mesh_;
};

}  // namespace keypose
