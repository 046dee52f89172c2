// The common part of all stage programs: ports, options, --describe, --help, progress, report, exit
// codes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/values/options.h"
#include "core/values/progress.h"

namespace keypose {

struct Port {
  std::string name = {};
  std::string kind = {};  ///< "file", "folder", or "path" (file or folder; in a pipeline a file)
  std::string help = {};
  std::string file = {};  ///< outputs: the name in a pipeline's folders, e.g. "clean.ply", "images"
  bool optional = false;
  bool repeatable = false;
  bool in_place = false;  ///< file outputs: may replace an input, because it is made from it
};

constexpr double kAnyNumber = std::numeric_limits<double>::infinity();

/// What a measurement of the report means, for those who show it.
struct Measurement {
  std::string key = {};    ///< its name in the report
  std::string label = {};  ///< e.g. "overlap with the masks, mean"
  /// "px", "m", "s", "dB", "share" (0 to 1, shown in percent), "diagonal" (of the mesh's, likewise)
  std::string unit = {};
  /// what a good result has, where that can be said; flags count as 0 and 1
  double good_min = -kAnyNumber, good_max = kAnyNumber;
};

/// Description of a stage.
struct StageSpec {
  std::string name = {};
  std::string version = {};  ///< changes when the same inputs and options would give another result
  std::string summary = {};  ///< one sentence
  std::string title = {};    ///< what an artist calls its work, e.g. "Clean mesh"
  std::vector<Measurement> measurements = {};  ///< the most important ones, in the order to show
  std::vector<Port> inputs = {}, outputs = {};
  /// external programs that it calls, e.g. "colmap"; their versions are part of the fingerprint
  std::vector<std::string> tools = {};
  /// files of the installation that it reads where they are there, e.g. "isnet.onnx" (see
  /// core/io/text/shared_files.h); their versions are part of the fingerprint too
  std::vector<std::string> shared_files = {};
  int cores = 0;          ///< cores it can use; 0 means all
  double memory_gib = 1;  ///< approximate peak memory
  /// names of the most used options; --help lists them first, in the order of the struct
  std::vector<std::string> common = {};
};

/// The inputs, outputs and report of a running stage. Outputs appear at their final path only when
/// the stage succeeds.
class StageContext {
 public:
  virtual ~StageContext() = default;
  virtual bool Has(std::string_view port) const = 0;
  virtual std::filesystem::path Input(std::string_view port) const = 0;
  virtual std::vector<std::filesystem::path> Inputs(
      std::string_view port) const = 0;  ///< of a repeatable port, in order
  /// Where to write the output. For a folder port, the folder is created. An empty path when an
  /// optional output was not requested.
  virtual std::filesystem::path Output(std::string_view port) = 0;
  virtual std::filesystem::path Scratch() = 0;  ///< an empty folder, deleted at the end
  virtual Progress* progress() = 0;

  /// Adds a measurement to the report.
  virtual void Report(std::string_view name, double value) = 0;
  virtual void Report(std::string_view name, std::int64_t value) = 0;
  void Report(std::string_view name, int value) { Report(name, static_cast<std::int64_t>(value)); }
  virtual void Report(std::string_view name, bool value) = 0;
  virtual void Report(std::string_view name, const std::string& value) = 0;
  void Report(std::string_view name, const char* value) { Report(name, std::string(value)); }
  /// Adds a measurement that is a JSON text (array or object).
  virtual void ReportJson(std::string_view name, const std::string& json) = 0;
  /// Writes a line to the log, for the user.
  virtual void Note(const std::string& line) = 0;
  /// A warning that the user should read before they trust the result: one sentence that says what
  /// is wrong, where, and what to do. It is written once, to the log and to `warnings` of the
  /// report.
  /// `keypose run` repeats it at its end, also when the step comes from the cache.
  virtual void Warn(const std::string& sentence) = 0;
  /// The verdict on a pose, or on another object that the user asks about. It is written to
  /// `verdicts` of the report, and `keypose run` prints it at its end.
  /// @param about  e.g. the pose's name
  /// @param grade  "good", "look" (usable, but should be checked) or "wrong"
  /// @param why  the reason, and the remedy when the grade is not "good"
  virtual void Verdict(const std::string& about, const std::string& grade,
                       const std::string& why) = 0;
};

/// Runs an external program and writes its output to the log. The program is found on PATH, or by
/// the environment variable KEYPOSE_<NAME> (upper case) when that is set.
/// @return its standard output and error together
/// @throws ToolError  not installed (names the Debian package), or it failed (gives its last lines
/// and the exit code)
/// @throws Cancelled  the user interrupted; the program's whole process group is stopped
std::string RunTool(StageContext& stage, const std::string& program,
                    const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment = {});
/// The first line of the tool's version output; "missing" when the tool is not installed.
std::string ToolVersion(const std::string& program);

namespace internal {
struct BoundOptions {
  std::function<void(OptionVisitor&)> visit;
  std::function<std::vector<std::string>()> problems;
};
struct BoundAction {
  std::string name, help;
  std::function<void(const std::filesystem::path&)> run;
};
int Main(int argc, char** argv, const StageSpec& spec, const BoundOptions& options,
         const std::function<void(StageContext&)>& run, const std::vector<BoundAction>& actions);
}  // namespace internal

/// An action that a stage's program does instead of its run when `--NAME FILE` is given. Ports are
/// then neither needed nor allowed.
template <class Options>
struct StageAction {
  std::string name, help;
  void (*run)(const std::filesystem::path& file, const Options& options);
};

/// The complete main function of a stage: parses, checks, runs, reports, and returns the exit code.
template <class Options>
int RunStage(int argc, char** argv, const StageSpec& spec,
             void (*run)(StageContext&, const Options&),
             const std::vector<StageAction<Options>>& actions = {}) {
  Options options;
  internal::BoundOptions bound;
  bound.visit = [&](OptionVisitor& visitor) { options.Describe(visitor); };
  if constexpr (requires { options.Problems(); })
    bound.problems = [&] { return options.Problems(); };
  std::vector<internal::BoundAction> bound_actions;
  for (const StageAction<Options>& action : actions)
    bound_actions.push_back({action.name, action.help, [&](const std::filesystem::path& file) {
                               action.run(file, options);
                             }});
  return internal::Main(
      argc, argv, spec, bound, [&](StageContext& context) { run(context, options); },
      bound_actions);
}

}  // namespace keypose
