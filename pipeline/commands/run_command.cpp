#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>

#include "pipeline/cache/project_lock.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/run/builder.h"
#include "pipeline/run/display.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/run/run_checks.h"
#include "pipeline/text/terminal.h"

namespace keypose::pipeline {
namespace {

int MachineCores() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

std::int64_t MemoryAvailable() {
  std::ifstream in("/proc/meminfo");
  std::string name, unit;
  for (std::int64_t kilobytes = 0; in >> name >> kilobytes;) {
    if (name == "MemAvailable:") return kilobytes * 1024;
    std::getline(in, unit);
  }
  return 0;
}

/// Number of programs that wanted a core in the last minute; 0 if the system does not tell.
double MachineLoad() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : 0;
}

DisplayKind KindOf(const std::string& progress) {
  if (progress == "jsonl") return DisplayKind::kJsonLines;
  if (progress == "bars") return DisplayKind::kBars;
  if (progress == "lines") return DisplayKind::kLines;
  return OnTerminal() ? DisplayKind::kBars : DisplayKind::kLines;
}

void PrintPlan(const Plan& plan) {
  int count = 0;
  for (int i = 0; i < plan.size(); ++i) {
    if (!plan[i].wanted || plan[i].state == StepPlan::State::kDone) continue;
    ++count;
    const std::string& id = plan.graph().steps[i].id;
    if (plan[i].state == StepPlan::State::kReady) {
      fmt::print("would run {}: {}\n", id, fmt::join(plan[i].reasons, "; "));
    } else {
      fmt::print("would check {} again after {}\n", id, fmt::join(plan.WaitsFor(i), ", "));
    }
  }
  if (count == 0) fmt::print("all is up to date\n");
}

std::string RunName(double now) {
  const std::time_t seconds = static_cast<std::time_t>(now);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%dT%H%M%S", &utc);
  return fmt::format("{}-{:03}-{}", text,
                     static_cast<int>((now - static_cast<double>(seconds)) * 1000), getpid());
}

std::string OwnHostName() {
  char name[256] = {};
  gethostname(name, sizeof name - 1);
  return name;
}

/// Plans and runs. If an input changes during the run, it ends with `again`.
RunResult RunOnce(const std::filesystem::path& project, const std::vector<Override>& overrides,
                  const RunOptions& options, ProjectLock* lock) {
  OpenedProject opened(project, overrides, true);
  if (lock) opened.processes().KeepOpen(lock->fd());
  if (lock) opened.disk().Remove(opened.state() / "writing");
  Plan plan(opened.graph(), opened.workshop(), options.selection);
  RequireRunnable(plan, opened.file(), opened.processes());
  if (options.dry_run) {
    PrintPlan(plan);
    return {};
  }
  ResultsFolder results(opened.disk(), opened.out(), opened.state() / "out.json");
  const auto display = MakeDisplay(KindOf(options.progress), opened.clock());
  const Limits limits{options.cores > 0 ? options.cores : MachineCores(), MemoryAvailable(),
                      MachineLoad()};
  Builder builder(plan, opened.workshop(), opened.processes(), opened.clock(), results, *display,
                  limits);
  RunRecord record;
  record.name = RunName(opened.clock().Now());
  record.command = options.command_line;
  record.host = OwnHostName();
  const RunResult result = builder.Run(std::move(record));
  opened.disk().Remove(opened.state() / "writing");
  return result;
}

}  // namespace

ExitCode RunCommand(const RunOptions& options) {
  if (options.cores < 0)
    throw UsageError(fmt::format("-j {}: it must be 1 or more", options.cores));
  const std::filesystem::path project = FindProject(options.folder);
  std::vector<Override> overrides;
  for (const std::string& text : options.set) overrides.push_back(ParseOverride(text));
  std::unique_ptr<ProjectLock> lock;
  if (!options.dry_run)
    lock = std::make_unique<ProjectLock>(project / ".keypose", options.command_line);
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    const RunResult result = RunOnce(project, overrides, options, lock.get());
    if (result.again && result.code == ExitCode::kOk) continue;
    if (result.code != ExitCode::kOk) {
      const std::string start =
          result.code == ExitCode::kInterrupted ? "keypose: " : "\nkeypose: error: ";
      std::fputs((start + result.message + "\n").c_str(), stderr);
    }
    return result.code;
  }
  throw InputError(
      fmt::format("files were changed during each of {} tries, see the warnings above; wait until "
                  "nothing writes to them, and run again",
                  kRounds));
}

}  // namespace keypose::pipeline
