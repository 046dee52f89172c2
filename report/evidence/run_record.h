// The record of a run: the inputs, outputs and measurements of each step.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace keypose::report {

/// What a stage says of one of its measurements.
struct Described {
  std::string key, label;
  std::string unit;  ///< "share" and "diagonal" are shown in percent
  std::optional<double> good_min, good_max;
};

/// One step of the run with its stage's report.
struct StepRecord {
  std::string title;  ///< what an artist calls its work; the stage's name where it says none
  std::vector<Described> described;  ///< its most important measurements, in the order to show
  std::string id, step, stage, pose, source_pose, status = "done", fingerprint, version;
  double seconds = 0;
  std::int64_t peak_bytes = 0;
  bool cached = false;
  std::map<std::string, double> numbers;     ///< measurements; booleans are 0 and 1
  std::map<std::string, bool> flags;         ///< measurements that are booleans
  std::map<std::string, std::string> texts;  ///< measurements that are words
  /// measurements that are arrays or objects, as JSON text
  std::map<std::string, std::string> lists;
  std::map<std::string, std::string> options;            ///< as used, as JSON text
  std::map<std::string, std::filesystem::path> outputs;  ///< by port
  std::map<std::string, std::vector<std::filesystem::path>> inputs;
  std::vector<std::string> warnings;  ///< the stage's warnings to the user
  std::string trouble;                ///< why its report could not be read; empty if it could

  std::optional<double> Number(const std::string& name) const;
  std::filesystem::path Output(
      const std::string& port) const;  ///< empty if the step has no such output
  std::filesystem::path Input(const std::string& port) const;  ///< first path of the port
  bool done() const { return status == "done"; }
};

struct RunRecord {
  std::string project, template_pose;
  std::vector<std::string> poses;
  bool performance = false;  ///< a scan that moves as an actor in films; `poses` are its shots
  std::string timeline;      ///< JSON text; empty if there is none
  std::vector<StepRecord> steps;

  /// The step of a stage on a pose, or null. An empty pose finds steps of the whole project or
  /// animation.
  const StepRecord* Find(const std::string& stage, const std::string& pose = "") const;
  /// The final texture of a pose: completed from other poses, else as baked; empty if there is
  /// none.
  std::filesystem::path TextureOf(const std::string& pose) const;
  std::vector<const StepRecord*> All(const std::string& stage) const;
  /// The step that exports the frames of a folder, or null. A project may export other motions too,
  /// such as a puppet's takes.
  const StepRecord* ExportOf(const std::filesystem::path& frames) const;
  /// Pictures a second at which those frames were exported; 0 if that step was not told.
  double ExportedRate(const std::filesystem::path& frames) const;
};

/// Returns a file's text, or throws.
using FileReader = std::function<std::string(const std::filesystem::path&)>;

/// The record from the text of run.json. `read` reads the report of every step in it.
///
/// A missing or malformed report of a step is noted in StepRecord::trouble: a broken run needs a
/// report most.
/// @param folder  base of relative paths
/// @throws InputError  not the record of a run
RunRecord ParseRun(const std::string& text, const std::filesystem::path& folder,
                   const FileReader& read);

}  // namespace keypose::report
