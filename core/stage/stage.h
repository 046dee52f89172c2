// What every stage program shares: ports, options, --describe, --help, progress, report, exit
// codes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/options.h"
#include "core/progress.h"

namespace keypose {

struct Port {
  std::string name = {};
  std::string kind = {};  ///< "file", "folder", or "path": either by hand, a file in a pipeline
  std::string help = {};
  std::string file = {};  ///< outputs: name that the runner gives it, e.g. "clean.ply", "images"
  bool optional = false;
  bool repeatable = false;
  bool in_place = false;  ///< file outputs: may take the place of an input, which it is made from
};

/// What a stage says of itself.
struct StageSpec {
  std::string name = {};
  std::string version = {};  ///< changes whenever the same inputs and options would give other bits
  std::string summary = {};  ///< one sentence
  std::vector<Port> inputs = {}, outputs = {};
  /// external programs it calls, e.g. "colmap"; their versions enter the fingerprint
  std::vector<std::string> tools = {};
  int cores = 0;                         ///< cores it can use; 0 means all
  double memory_gib = 1;                 ///< what it needs at most, roughly
  std::vector<std::string> common = {};  ///< options that most people will want; --help has them
                                         ///< first, in the order of the struct
};

/// Files in, files out. Outputs appear at their final path only when the stage succeeded.
class StageContext {
 public:
  virtual ~StageContext() = default;
  virtual bool Has(std::string_view port) const = 0;
  virtual std::filesystem::path Input(std::string_view port) const = 0;
  virtual std::vector<std::filesystem::path> Inputs(
      std::string_view port) const = 0;  ///< of a repeatable port, in order
  /// Where to write; a folder port is created. Empty path when an optional output was not asked
  /// for.
  virtual std::filesystem::path Output(std::string_view port) = 0;
  virtual std::filesystem::path Scratch() = 0;  ///< an empty folder, deleted at the end
  virtual Progress* progress() = 0;

  /// One measurement of the report.
  virtual void Report(std::string_view name, double value) = 0;
  virtual void Report(std::string_view name, std::int64_t value) = 0;
  void Report(std::string_view name, int value) { Report(name, static_cast<std::int64_t>(value)); }
  virtual void Report(std::string_view name, bool value) = 0;
  virtual void Report(std::string_view name, const std::string& value) = 0;
  void Report(std::string_view name, const char* value) { Report(name, std::string(value)); }
  /// A measurement that is a whole JSON text (array or object).
  virtual void ReportJson(std::string_view name, const std::string& json) = 0;
  /// A line for a person, to the log.
  virtual void Note(const std::string& line) = 0;
  /// What a person should know before they trust the result: one sentence that says what, where,
  /// and what to do. It goes to the log and to `warnings` of the report; `keypose run` repeats it
  /// at its end, also when the step is taken from the cache.
  virtual void Warn(const std::string& sentence) = 0;
  /// The judgement of a pose, or of another thing that a person asks about. It goes to `verdicts`
  /// of the report; `keypose run` ends with it.
  /// @param about  e.g. the pose's name  @param grade  "good", "look" (usable, but worth a glance)
  /// or "wrong"
  /// @param why    what decided, and the cure where it is not good
  virtual void Verdict(const std::string& about, const std::string& grade,
                       const std::string& why) = 0;
};

/// Runs an external program found on PATH (or by KEYPOSE_<NAME>, upper case, when that is set), its
/// output to the log.
/// @return its standard output and error together
/// @throws ToolError  not installed (says which Debian package), or it failed (gives its last lines
/// and the exit code)
/// @throws Cancelled  the user interrupted; the program's whole process group is stopped
std::string RunTool(StageContext& stage, const std::string& program,
                    const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment = {});
/// First line that the tool says of its version, "missing" when it is not there.
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

/// Something that a stage's program does instead of its run when `--NAME FILE` is given: then no
/// port is needed, and none is taken.
template <class Options>
struct StageAction {
  std::string name, help;
  void (*run)(const std::filesystem::path& file, const Options& options);
};

/// The whole of a stage's main: parses, checks, runs, reports, and returns the exit code.
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
