// The cache: one folder per artifact, named by its fingerprint. An artifact is complete or absent.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/cache/fingerprint.h"
#include "pipeline/disk/disk.h"
#include "pipeline/graph/stage_info.h"

namespace keypose::pipeline {

struct ArtifactOutput {
  std::string file;  ///< name in the artifact's folder
  bool folder = false;
  Content content;
};

struct Artifact {
  std::string fingerprint;
  std::filesystem::path folder;  ///< absolute; has the outputs, log.txt, report.json, manifest.json
  Recipe recipe;
  std::map<std::string, ArtifactOutput> outputs;  ///< by port
  double seconds = 0;
  std::int64_t peak_bytes = 0;

  std::filesystem::path Path(const std::string& port) const {
    return folder / outputs.at(port).file;
  }
};

class ArtifactStore {
 public:
  /// @param state_folder  the project's .keypose
  ArtifactStore(Disk& disk, std::filesystem::path state_folder);

  /// The artifact if it is in the cache and all its files are unchanged; else nothing. A file with
  /// the same size, times and inode counts as unchanged. Any other file is read and hashed; if its
  /// hash is right, its new size, times and inode are remembered.
  /// @param damage  receives a message for the user if an artifact is there but damaged
  std::optional<Artifact> Find(const std::string& fingerprint, std::string* damage = nullptr) const;

  /// Like Find, but reads every file: a failing disk changes content without changing size or
  /// times.
  /// @return a message for the user that says what is wrong; empty if nothing is
  std::string Verify(const std::string& fingerprint) const;

  /// Hashes the outputs in `made`, writes the manifest there, and renames the folder into place.
  /// Replaces an artifact of the same fingerprint.
  /// @throws ToolError  a required output was not written @throws DiskError
  Artifact Commit(const std::filesystem::path& made, const StageInfo& info, const Recipe& recipe,
                  double seconds, std::int64_t peak_bytes);

  std::filesystem::path FolderOf(const std::string& fingerprint) const;
  /// Fingerprints of all folders in the cache, complete or not.
  std::vector<std::string> All() const;
  /// @return total size of the artifact's files [bytes]
  std::uint64_t SizeOf(const std::string& fingerprint) const;
  void Remove(const std::string& fingerprint);

 private:
  enum class Reading { kChanged, kAll };
  std::optional<Artifact> Look(const std::string& fingerprint, Reading reading,
                               std::string* damage) const;
  void Remember(const std::filesystem::path& manifest_file, nlohmann::json manifest,
                nlohmann::json files) const;
  ArtifactOutput Measure(const std::filesystem::path& made, const PortInfo& port) const;

  Disk& disk_;
  std::filesystem::path state_folder_;
};

}  // namespace keypose::pipeline
