// Photographs get their names when all of them is on the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/shoot/devices/camera_device.h"
#include "capture/shoot/record/shot_plan.h"
#include "capture/shoot/record/side_file.h"

namespace keypose::capture::shoot {

/// The folder of a pose's photographs.
class PhotographStore {
 public:
  /// Makes the folder, and removes what an interrupted session left in `.incoming`.
  /// @throws DiskError
  explicit PhotographStore(const std::filesystem::path& folder);
  /// Removes `.incoming`.
  ~PhotographStore();
  PhotographStore(const PhotographStore&) = delete;
  PhotographStore& operator=(const PhotographStore&) = delete;

  /// An empty folder for the camera's files.
  std::filesystem::path Incoming() const;
  /// Gives the files of one exposure their names, NAME.jpg, NAME.cr2, each once it is on the disk.
  /// Other files of this name are removed: the photograph replaces them.
  /// @throws InputError  two of them have one extension @throws DiskError
  void Add(const std::string& name, const Exposure& exposure, std::int64_t time);
  /// Keeps the photographs of a focus stack in stacks/, and the merged one as NAME.jpg.
  void AddStack(const std::string& name, const std::vector<Exposure>& exposures,
                const std::filesystem::path& merged, std::int64_t time);

  /// The photograph's file, or its RAW file if that is the only one; empty if it is not there.
  std::filesystem::path FileOf(const std::string& name) const;
  std::filesystem::path RawOf(const std::string& name) const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::vector<std::filesystem::path> AllOf(const std::string& name) const;
  std::filesystem::path folder_;
};

/// Replaces a file by one that is complete, also after a power cut.
/// @throws DiskError
void WriteDurably(const std::filesystem::path& file, const std::string& text);

/// When a file landed [seconds since 1970].
std::int64_t TimeOfFile(const std::filesystem::path& file);

}  // namespace keypose::capture::shoot
