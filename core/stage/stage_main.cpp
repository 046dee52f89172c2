#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <new>
#include <optional>

#include "core/io/text/files.h"
#include "core/io/text/shared_files.h"
#include "core/numbers/parallel.h"
#include "core/stage/awaited_arguments.h"
#include "core/stage/interruption.h"
#include "core/stage/output_guard.h"
#include "core/stage/stage_context.h"
#include "core/stage/stage_options.h"
#include "core/values/kept_memory.h"
#include "core/values/late_library.h"
#include "core/values/size_of.h"

namespace keypose::internal {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// The runner kills a stage 5 seconds after SIGTERM (docs/stage-contract.md).
constexpr double kGrace_s = 3;

/// Progress as JSON lines to the runner's descriptor, or as percent lines for a person at a
/// terminal.
class StageProgress final : public Progress {
 public:
  explicit StageProgress(const std::string& stage) : stage_(stage) {
    if (const char* text = std::getenv("KEYPOSE_PROGRESS_FD")) descriptor_ = std::atoi(text);
    // Programs that this stage starts must not keep the runner's pipe open.
    if (descriptor_ >= 0 && fcntl(descriptor_, F_SETFD, FD_CLOEXEC) != 0) descriptor_ = -1;
    terminal_ = descriptor_ < 0 && isatty(STDERR_FILENO);
  }
  bool cancelled() const override { return Interruption::Asked(); }
  void Update(double fraction, std::string_view what) override {
    const std::lock_guard lock(mutex_);  // some algorithms report from each of their threads
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(100) && what == last_what_) return;
    last_ = now;
    last_what_ = what;
    if (descriptor_ >= 0) {
      const std::string line = json{{"fraction", fraction}, {"what", what}}.dump() + "\n";
      if (write(descriptor_, line.data(), line.size()) < 0) descriptor_ = -1;
    } else if (terminal_) {
      std::fprintf(stderr, "\r\033[K%s %3.0f %%  %.*s", stage_.c_str(), 100 * fraction,
                   SizeOf(what), what.data());
      std::fflush(stderr);
      drawn_ = true;
    }
  }
  ~StageProgress() override {
    if (drawn_) std::fprintf(stderr, "\n");
  }

 private:
  std::string stage_;
  int descriptor_ = -1;
  bool terminal_ = false, drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
  std::string last_what_;
  std::mutex mutex_;
};

json DescribePorts(const std::vector<Port>& ports) {
  json list = json::array();
  for (const Port& port : ports)
    list.push_back({{"name", port.name},
                    {"kind", port.kind},
                    {"file", port.file},
                    {"optional", port.optional},
                    {"repeatable", port.repeatable},
                    {"help", port.help}});
  return list;
}

json DescribeMeasurements(const std::vector<Measurement>& measurements) {
  json list = json::array();
  for (const Measurement& one : measurements) {
    json described = {{"key", one.key}, {"label", one.label}, {"unit", one.unit}};
    if (std::isfinite(one.good_min)) described["good"]["min"] = one.good_min;
    if (std::isfinite(one.good_max)) described["good"]["max"] = one.good_max;
    list.push_back(described);
  }
  return list;
}

json Describe(const StageSpec& spec, const BoundOptions& options) {
  DescribeVisitor visitor(spec.common);
  options.visit(visitor);
  json tools = json::array();
  for (const std::string& tool : spec.tools)
    tools.push_back({{"name", tool}, {"version", ToolVersion(tool)}});
  for (const std::string& file : spec.shared_files)
    tools.push_back({{"name", file}, {"version", SharedFileVersion(file)}});
  return {{"schema", 1},
          {"stage", spec.name},
          {"version", spec.version},
          {"summary", spec.summary},
          {"title", spec.title},
          {"measurements", DescribeMeasurements(spec.measurements)},
          {"inputs", DescribePorts(spec.inputs)},
          {"outputs", DescribePorts(spec.outputs)},
          {"options", visitor.options},
          {"tools", tools},
          {"resources",
           {{"cores", spec.cores},
            {"memory_bytes", static_cast<std::int64_t>(spec.memory_gib * (1 << 30))}}}};
}

std::string RangeText(double min, double max) {
  if (std::isfinite(min) && std::isfinite(max)) return fmt::format(", {} to {}", min, max);
  if (std::isfinite(min)) return fmt::format(", at least {}", min);
  return std::isfinite(max) ? fmt::format(", at most {}", max) : "";
}

/// Adds a flag for each common option, or for each other option. The parsed value is stored in the
/// options struct.
class FlagVisitor final : public OptionVisitor {
 public:
  FlagVisitor(CLI::App& app, const std::vector<std::string>& common, bool add_common)
      : app_(app), common_(common), add_common_(add_common) {}
  void operator()(const char* name, bool& value, const OptionDoc& doc) override {
    if (CLI::Option* flag = Add(name, value, doc.help))
      flag->type_name("true|false")->default_str(value ? "true" : "false");
  }
  void operator()(const char* name, int& value, const OptionDoc& doc) override {
    AddNumber(name, value, doc);
  }
  void operator()(const char* name, double& value, const OptionDoc& doc) override {
    AddNumber(name, value, doc);
  }
  void operator()(const char* name, std::string& value, const OptionDoc& doc) override {
    CLI::Option* flag = Add(name, value, doc.help);
    if (flag && !doc.choices.empty())
      flag->type_name(fmt::format("{}", fmt::join(doc.choices, "|")));
  }
  int added() const { return added_; }

 private:
  template <class T>
  void AddNumber(const char* name, T& value, const OptionDoc& doc) {
    const std::string unit = doc.unit.empty() ? "" : " [" + doc.unit + "]";
    Add(name, value, doc.help + unit + RangeText(doc.min, doc.max));
  }
  template <class T>
  CLI::Option* Add(const char* name, T& value, const std::string& help) {
    const bool is_common = std::find(common_.begin(), common_.end(), name) != common_.end();
    if (is_common != add_common_) return nullptr;
    ++added_;
    const char* group = is_common ? "Common options" : "Further options";
    if (common_.empty()) group = "Options";
    return app_.add_option(fmt::format("--{}", name), value, help)
        ->capture_default_str()
        ->group(group);
  }
  CLI::App& app_;
  const std::vector<std::string>& common_;
  bool add_common_;
  int added_ = 0;
};

struct Arguments {
  PortPaths inputs, outputs;
  fs::path report;
  const BoundAction* action = nullptr;  // done instead of the run
  fs::path action_file;
  bool overwrite = false;
};

/// Parses argv.
/// @return an exit code when the run ends here (help, describe, check, usage error)
class CommandLine {
 public:
  CommandLine(const StageSpec& spec, const BoundOptions& options,
              const std::vector<BoundAction>& actions)
      : spec_(spec),
        options_(options),
        actions_(actions),
        app_(spec.summary, "keypose " + spec.name) {
    app_.set_help_flag();  // added again below: groups are shown in the order in which they appear
                           // here
    AddPorts(spec.inputs, "Inputs");
    AddPorts(spec.outputs, "Outputs");
    for (const BoundAction& action : actions_)
      app_.add_option("--" + action.name, action_files_[action.name], action.help)
          ->group("Instead of a run")
          ->type_name("FILE");
    AddOptions();
    const char* rest = "Report and help";
    if (!HasReportPort())
      app_.add_option("--report", report_, "write measurements to this JSON file")
          ->group(rest)
          ->type_name("FILE");
    app_.add_flag("--overwrite", overwrite_,
                  "replace output folders even if they hold files that this stage did not write")
        ->group(rest);
    app_.set_help_flag("-h,--help", "print this help")->group(rest);
    app_.set_version_flag("--version", "keypose " + spec.name + " " + spec.version,
                          "print the stage's version")
        ->group(rest);
    app_.add_flag("--describe", describe_, "print ports and options as JSON")->group(rest);
    app_.add_flag("--check_options", check_, "only say whether the options can be used so")
        ->group(rest);
  }

  std::optional<int> Parse(int argc, char** argv, Arguments& arguments) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
      PrintHelp();
      return 0;
    } catch (const CLI::CallForVersion& version) {
      std::cout << version.what() << "\n";
      return 0;
    } catch (const CLI::ParseError& error) {
      throw UsageError(std::string(error.what()) + Suggestion() + "; 'keypose " + spec_.name +
                       " --help' lists ports and options");
    }
    if (describe_) {
      std::cout << Describe(spec_, options_).dump(1) << "\n";
      return 0;
    }
    if (check_) {
      CheckOptions();
      return 0;
    }
    if (TakeAction(arguments)) return std::nullopt;
    TakeReportFile();
    arguments.report = report_;
    arguments.overwrite = overwrite_;
    Bind(spec_.inputs, true, arguments.inputs);
    Bind(spec_.outputs, false, arguments.outputs);
    CheckOptions();
    return std::nullopt;
  }

 private:
  void AddOptions() {
    FlagVisitor common(app_, spec_.common, true), further(app_, spec_.common, false);
    options_.visit(common);
    options_.visit(further);
    common_added_ = common.added();
  }

  void PrintHelp() const {
    // Checked here and not earlier: a wrong name in the help must not stop a run.
    if (common_added_ != std::ssize(spec_.common))
      throw std::logic_error(
          fmt::format("stage {} lists a common option that it does not have", spec_.name));
    std::cout << app_.help();
  }

  void AddPorts(const std::vector<Port>& ports, const char* group) {
    for (const Port& port : ports) {
      auto* flag =
          app_.add_option("--" + port.name, paths_[port.name],
                          port.help + " (" + port.kind + (port.optional ? ", optional" : "") + ")");
      flag->group(group)->allow_extra_args(false)->type_name("PATH");
      if (!port.repeatable && port.name != "report")
        flag->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::Throw);
    }
  }

  bool HasReportPort() const {
    return std::any_of(spec_.outputs.begin(), spec_.outputs.end(),
                       [](const Port& port) { return port.name == "report"; });
  }

  /// @return whether the command line asks for something other than a run
  bool TakeAction(Arguments& arguments) {
    for (const BoundAction& action : actions_)
      if (app_.count("--" + action.name)) {
        arguments.action = &action;
        arguments.action_file = action_files_[action.name];
      }
    if (!arguments.action) return false;
    for (const auto& [port, given] : paths_)
      if (!given.empty())
        throw UsageError(fmt::format("--{} replaces the run and does not accept --{}; leave it out",
                                     arguments.action->name, port));
    CheckOptions();
    return true;
  }

  /// A stage with an output named `report` accepts --report twice: a .json path is the file of
  /// measurements, the other one is the output.
  void TakeReportFile() {
    if (!HasReportPort()) return;
    auto& given = paths_["report"];
    const auto is_file = [](const std::string& path) {
      return fs::path(path).extension() == ".json";
    };
    const auto file = std::find_if(given.begin(), given.end(), is_file);
    if (file != given.end()) {
      report_ = *file;
      given.erase(file);
    }
    if (given.size() > 1)
      throw UsageError(
          "--report is given more than once; name one output, and at most one .json file for the "
          "measurements");
  }

  std::string Suggestion() {
    const auto extras = app_.remaining();
    std::vector<std::string> known;
    for (const auto* option : app_.get_options()) known.push_back(option->get_name());
    for (const std::string& extra : extras)
      if (extra.rfind("--", 0) == 0)
        return "; did you mean " + NearestWord(extra.substr(0, extra.find('=')), known) + "?";
    return "";
  }

  void Bind(const std::vector<Port>& ports, bool must_exist, PortPaths& bound) {
    for (const Port& port : ports) {
      const auto& given = paths_[port.name];
      if (given.empty() && !port.optional)
        throw UsageError(fmt::format("--{} is missing: {}", port.name, port.help));
      if (given.empty()) continue;
      for (const std::string& path : given) {
        if (must_exist && !fs::exists(path))
          throw InputError(fmt::format("{}: --{} {} does not exist; check the path", spec_.name,
                                       port.name, path));
        if (must_exist && port.kind == "folder" && !fs::is_directory(path))
          throw InputError(fmt::format("{}: --{} {} is not a folder", spec_.name, port.name, path));
        if (must_exist && port.kind == "file" && fs::is_directory(path))
          throw InputError(fmt::format("{}: --{} {} is a folder, but a file is needed", spec_.name,
                                       port.name, path));
        bound[port.name].emplace_back(path);
      }
    }
  }

  void CheckOptions() {
    CheckVisitor check;
    options_.visit(check);
    std::vector<std::string> problems = check.problems;
    if (options_.problems)
      for (std::string& problem : options_.problems()) problems.push_back(std::move(problem));
    if (!problems.empty()) throw UsageError(fmt::format("{}", fmt::join(problems, "; ")));
  }

  const StageSpec& spec_;
  const BoundOptions& options_;
  const std::vector<BoundAction>& actions_;
  CLI::App app_;
  std::map<std::string, std::vector<std::string>> paths_;
  std::map<std::string, std::string> action_files_;
  std::string report_;
  bool describe_ = false, check_ = false, overwrite_ = false;
  int common_added_ = 0;
};

std::int64_t PeakBytes() {
  rusage own{}, children{};
  getrusage(RUSAGE_SELF, &own);
  getrusage(RUSAGE_CHILDREN, &children);
  return std::int64_t{1024} * std::max(own.ru_maxrss, children.ru_maxrss);
}

void WriteReport(const StageSpec& spec, const BoundOptions& options, const fs::path& path,
                 double seconds, const RunningStage& stage) {
  ValuesVisitor values;
  options.visit(values);
  const json report = {{"schema", 1},
                       {"stage", spec.name},
                       {"version", spec.version},
                       {"options", values.values},
                       {"seconds", seconds},
                       {"peak_bytes", PeakBytes()},
                       {"measurements", stage.measurements()},
                       {"warnings", stage.warnings()},
                       {"verdicts", stage.verdicts()}};
  WriteFileAtomically(path, report.dump(1) + "\n");
}

int Run(int argc, char** argv, const StageSpec& spec, const BoundOptions& options,
        const std::function<void(StageContext&)>& run, const std::vector<BoundAction>& actions) {
  const auto start = std::chrono::steady_clock::now();
  Arguments arguments;
  CommandLine command_line(spec, options, actions);
  if (const auto code = command_line.Parse(argc, argv, arguments)) return *code;
  if (arguments.action) {
    arguments.action->run(arguments.action_file);
    return 0;
  }
  CheckOutputs(spec, arguments.inputs, arguments.outputs, arguments.report, arguments.overwrite);
  StageProgress progress(spec.name);
  RunningStage stage(spec, arguments.inputs, arguments.outputs,
                     {arguments.overwrite, !std::getenv("KEYPOSE_PROGRESS_FD")}, &progress);
  const Interruption interruption(kGrace_s, [&] {
    if (!stage.Abandon()) return false;
    std::fprintf(stderr, "keypose %s: error: %s\n", spec.name.c_str(), Cancelled().what());
    return true;
  });
  run(stage);
  if (Interruption::Asked()) throw Cancelled();
  stage.Commit();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (!arguments.report.empty())
    WriteReport(spec, options, arguments.report, seconds.count(), stage);
  return 0;
}

/// Rooms begin their messages with their name, which need not stand there twice.
int Fail(const StageSpec& spec, ExitCode code, const std::string& message) {
  const std::string name = spec.name + ": ";
  const std::string said = message.starts_with(name) ? message.substr(name.size()) : message;
  std::fprintf(stderr, "keypose %s: error: %s\n", spec.name.c_str(), said.c_str());
  return static_cast<int>(code);
}

}  // namespace

int Main(int argc, char** argv, const StageSpec& spec, const BoundOptions& options,
         const std::function<void(StageContext&)>& run, const std::vector<BoundAction>& actions) {
  KeepFreedMemory();
  std::vector<std::string> awaited;
  std::vector<char*> words(argv, argv + argc);
  if (argc == 2 && std::string(argv[1]) == "--await") {
    LoadLateLibraries();
    awaited = AwaitArguments(STDIN_FILENO);
    if (awaited.empty()) return 0;
    words.pop_back();
    for (std::string& argument : awaited) words.push_back(argument.data());
  }
  try {
    return Run(static_cast<int>(words.size()), words.data(), spec, options, run, actions);
  } catch (const Error& error) {
    return Fail(spec, error.code(), error.what());
  } catch (const fs::filesystem_error& error) {
    return Fail(spec, ExitCode::kDisk,
                std::string(error.what()) + "; check permissions and free space");
  } catch (const std::bad_alloc&) {
    return Fail(spec, ExitCode::kDisk,
                "out of memory; close other programs, or lower the resolution options");
  } catch (const std::exception& error) {
    return Fail(
        spec, ExitCode::kBug,
        std::string(error.what()) + " (this is a bug in Keypose; please report it with the log)");
  }
}

}  // namespace keypose::internal
