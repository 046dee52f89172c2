// What was made when: the records of all runs that the project still keeps.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

/// Whether the text can be a fingerprint, and so safely name a folder.
bool IsFingerprint(const std::string& text);

/// A step that a run made, or found in the cache.
struct PastStep {
  std::string id, fingerprint;
};

struct PastRun {
  std::string name;   ///< of its record
  std::string begin;  ///< "2026-03-01 14:05:09 UTC"
  std::vector<PastStep> steps;
};

/// The runs on record, oldest first. Of a damaged record only the steps that can be read.
/// @param state_folder  the project's .keypose
std::vector<PastRun> PastRuns(const Disk& disk, const std::filesystem::path& state_folder);

}  // namespace keypose::pipeline
