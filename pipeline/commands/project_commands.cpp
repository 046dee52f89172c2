// Commands that show or clean up a project's state and run no step.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "pipeline/cache/project_lock.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/run/builder.h"
#include "pipeline/run/collect_ending.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/run/results_folder.h"
#include "pipeline/run/time_left.h"
#include "pipeline/text/terminal.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

OpenedProject Open(const std::string& folder, const std::vector<std::string>& set = {}) {
  std::vector<Override> overrides;
  for (const std::string& text : set) overrides.push_back(ParseOverride(text));
  return OpenedProject(FindProject(folder), overrides);
}

/// The first few of many names.
std::string Some(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  if (names.size() <= kShown + 1) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{} and {} more", fmt::join(names.begin(), names.begin() + kShown, ", "),
                     names.size() - kShown);
}

std::string StatusText(const Plan& plan, int i) {
  const StepPlan& step = plan[i];
  const bool failed = step.last && step.last->failed;
  switch (step.state) {
    case StepPlan::State::kDone:
      return fmt::format("up to date   ({})", DurationText(step.artifact->seconds));
    case StepPlan::State::kReady:
      if (failed && step.last->failed_fingerprint == step.fingerprint)
        return fmt::format("failed       exit code {}; `keypose log` shows more",
                           step.last->exit_code);
      return fmt::format("{:<12} {}", step.last ? "would run" : "never ran",
                         step.last ? fmt::format("{}", fmt::join(step.reasons, "; ")) : "");
    default:
      return fmt::format("{:<12} for {}", step.last ? "waits" : "never, waits",
                         Some(plan.WaitsFor(i)));
  }
}

std::string Bullets(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += "  - " + line + "\n";
  return text;
}

}  // namespace

ExitCode StatusCommand(const std::string& folder, const std::vector<std::string>& set,
                       bool details) {
  OpenedProject opened = Open(folder, set);
  const Plan plan(opened.graph(), opened.workshop(), {});
  opened.workshop().hasher.Save();
  std::size_t width = 0;
  for (const Step& step : opened.graph().steps) width = std::max(width, WidthOf(step.id));
  for (int i = 0; i < plan.size(); ++i) {
    const std::string& id = opened.graph().steps[i].id;
    std::string line = id + std::string(width - WidthOf(id), ' ') + "  " + StatusText(plan, i);
    line.erase(line.find_last_not_of(' ') + 1);
    fmt::print("{}\n", line);
  }
  const Ending ending = EndingOf(plan, opened.disk(), opened.out());
  if (!ending.verdicts.empty())
    fmt::print("\n{}", VerdictsText(ending, TerminalColumns(), details));
  if (!ending.warnings.empty())
    fmt::print("\n{} of the steps that are up to date; `keypose run` shows them at its end\n",
               WarningCount(ending));
  return ExitCode::kOk;
}

std::string Explanation(const Plan& plan, int i) {
  const std::string& id = plan.graph().steps[i].id;
  const StepPlan& step = plan[i];
  std::string text;
  if (step.state == StepPlan::State::kReady) {
    text = fmt::format("{} would run because\n{}", id, Bullets(step.reasons));
    if (step.last && step.last->failed)
      text += fmt::format("  its last try, at {}, failed:\n{}\n", TimeText(step.last->when),
                          step.last->error);
  } else if (step.state == StepPlan::State::kDone) {
    text = fmt::format("{} is up to date\n", id);
    if (step.last && step.last->fingerprint == step.fingerprint && !step.last->reasons.empty()) {
      std::vector<std::string> reasons = step.last->reasons;
      std::replace(reasons.begin(), reasons.end(), std::string("it has never run"),
                   std::string("it had never run before"));
      text +=
          fmt::format("{} at {} because\n{}",
                      step.last->found ? "it was found in the cache, and not run," : "it last ran",
                      TimeText(step.last->when), Bullets(reasons));
    }
  } else {
    text = fmt::format("{} waits for {}; whether it runs depends on their results\n", id,
                       fmt::join(plan.WaitsFor(i), ", "));
  }
  return text;
}

std::string ExplanationWithCauses(const Plan& plan, const std::string& step) {
  std::string text;
  for (const int i : plan.graph().Find(step)) {
    text += Explanation(plan, i);
    // A waiting step gives no reason of its own: go up to the steps where the change begins.
    std::vector<int> above = {i};
    std::set<int> seen;
    while (!above.empty()) {
      const int one = above.back();
      above.pop_back();
      for (const int need : plan.graph().steps[one].needs) {
        if (plan[need].state == StepPlan::State::kDone || !seen.insert(need).second) continue;
        if (plan[need].state == StepPlan::State::kReady) text += Explanation(plan, need);
        above.push_back(need);
      }
    }
  }
  return text;
}

ExitCode ExplainCommand(const std::string& folder, const std::string& step,
                        const std::vector<std::string>& set) {
  OpenedProject opened = Open(folder, set);
  const Plan plan(opened.graph(), opened.workshop(), {});
  opened.workshop().hasher.Save();
  fmt::print("{}", ExplanationWithCauses(plan, step));
  return ExitCode::kOk;
}

fs::path StepLog(OpenedProject& opened, const std::string& id) {
  const auto last = opened.records().Last(id);
  if (!last) return {};
  const fs::path failed = opened.state() / "failed" / FolderName(id) / "log.txt";
  if (last->failed && fs::exists(failed)) return failed;
  if (last->fingerprint.empty()) return {};
  const fs::path good = opened.store().FolderOf(last->fingerprint) / "log.txt";
  return fs::exists(good) ? good : fs::path();
}

ExitCode LogCommand(const std::string& folder, const std::string& step) {
  OpenedProject opened = Open(folder);
  for (const int i : opened.graph().Find(step)) {
    const std::string& id = opened.graph().steps[i].id;
    const auto last = opened.records().Last(id);
    const fs::path log = StepLog(opened, id);
    if (!last) {
      fmt::print("--- {} has never run\n", id);
    } else if (log.empty()) {
      fmt::print("--- {} has no log any more{}\n", id,
                 last->failed ? "; it failed with\n" + last->error : "");
    } else {
      constexpr std::uintmax_t kShown = 4'000'000;
      const bool cut = fs::file_size(log) > kShown;
      fmt::print(
          "--- {} {} at {}: {}\n{}{}", id, last->failed ? "failed" : "was made",
          TimeText(last->when), log.string(),
          cut ? fmt::format("... (its last {}; the whole log is in the file)\n", SizeText(kShown))
              : "",
          opened.disk().ReadEnd(log, kShown));
    }
  }
  return ExitCode::kOk;
}

ExitCode GraphCommand(const std::string& folder, bool dot) {
  OpenedProject opened = Open(folder);
  if (dot) fmt::print("digraph keypose {{\n  rankdir=LR;\n  node [shape=box];\n");
  for (const Step& step : opened.graph().steps) {
    if (!dot) fmt::print("{} ({} {})\n", step.id, step.info->stage, step.info->version);
    if (dot) fmt::print("  \"{}\";\n", step.id);
    for (const PortFlows& port : step.inputs) {
      for (const Flow& flow : port.flows) {
        const std::string from = flow.step >= 0 ? opened.graph().steps[flow.step].id : flow.origin;
        if (dot) fmt::print("  \"{}\" -> \"{}\" [label=\"{}\"];\n", from, step.id, port.port);
        if (!dot) fmt::print("  {:<10} <- {}\n", port.port, flow.origin);
      }
    }
    for (const NamedResult& result : step.results) {
      const std::string from =
          result.inside.empty() ? result.port : result.port + "/" + result.inside;
      if (!dot) fmt::print("  {:<10} -> out/{}\n", from, result.path.generic_string());
    }
  }
  if (dot) fmt::print("}}\n");
  return ExitCode::kOk;
}

namespace {

/// Removes what the project keeps of old runs, and of steps that it no longer has.
void DropOldRecords(OpenedProject& opened, const std::set<std::string>& steps, int runs) {
  opened.records().DropOldRuns(runs);
  opened.records().ForgetStepsOutside(steps);
  std::set<std::string> failed;
  for (const std::string& step : steps) failed.insert(FolderName(step));
  for (const std::string& name : opened.disk().Children(opened.state() / "failed"))
    if (!failed.contains(name)) opened.disk().Remove(opened.state() / "failed" / name);
  opened.disk().Remove(opened.state() / "tmp");
  opened.disk().Remove(opened.state() / "writing");
}

}  // namespace

ExitCode GcCommand(const std::string& folder, bool dry_run, int keep_runs) {
  const fs::path project = FindProject(folder);
  const ProjectLock lock(project / ".keypose", "keypose gc");
  OpenedProject opened(project, {});
  std::set<std::string> steps;
  for (const Step& step : opened.graph().steps) steps.insert(step.id);
  std::set<std::string> keep = opened.records().Mentioned(keep_runs, steps);
  const Plan plan(opened.graph(), opened.workshop(), {});
  for (int i = 0; i < plan.size(); ++i) {
    if (plan[i].artifact) keep.insert(plan[i].fingerprint);
  }
  std::uint64_t freed = 0;
  int count = 0;
  for (const std::string& fingerprint : opened.store().All()) {
    if (keep.contains(fingerprint)) continue;
    freed += opened.store().SizeOf(fingerprint);
    ++count;
    if (!dry_run) opened.store().Remove(fingerprint);
  }
  if (!dry_run) DropOldRecords(opened, steps, std::max(keep_runs, 100));
  fmt::print("{} {} artifact{}, {}; kept {}\n", dry_run ? "would remove" : "removed", count,
             count == 1 ? "" : "s", SizeText(freed),
             opened.store().All().size() - (dry_run ? static_cast<std::size_t>(count) : 0));
  return ExitCode::kOk;
}

ExitCode VerifyCommand(const std::string& folder) {
  const fs::path project = FindProject(folder);
  const ProjectLock lock(project / ".keypose", "keypose verify");
  OpenedProject opened(project, {});
  std::map<std::string, std::string> step_of;
  for (const Step& step : opened.graph().steps)
    if (const auto last = opened.records().Last(step.id)) step_of[last->fingerprint] = step.id;
  const std::vector<std::string> all = opened.store().All();
  std::uint64_t bytes = 0;
  int damaged = 0;
  for (const std::string& fingerprint : all) {
    bytes += opened.store().SizeOf(fingerprint);
    const std::string damage = opened.store().Verify(fingerprint);
    if (damage.empty()) continue;
    ++damaged;
    const std::string& step = step_of[fingerprint];
    fmt::print("damaged: {} in {}{}\n", damage, opened.store().FolderOf(fingerprint).string(),
               step.empty() ? "" : ", made by " + step);
    opened.store().Remove(fingerprint);
  }
  ResultsFolder results(opened.disk(), opened.out(), opened.state() / "out.json");
  const std::vector<std::string> notes = results.Verify();
  for (const std::string& note : notes) fmt::print("{}\n", note);
  results.Save();
  if (damaged > 0)
    fmt::print(
        "the damaged artifacts were removed from the cache; `keypose run` makes them again\n");
  fmt::print("{} artifacts, {}: {}\n", all.size(), SizeText(bytes),
             damaged > 0 ? fmt::format("{} damaged", damaged) : "all are as they were made");
  return damaged > 0 || !notes.empty() ? ExitCode::kDisk : ExitCode::kOk;
}

ExitCode UnlockCommand(const std::string& folder, bool force) {
  fmt::print("{}\n", Unlock(FindProject(folder) / ".keypose", force));
  return ExitCode::kOk;
}

namespace {

/// Why the report in out/ is not what a run would make now; empty if it is.
std::string WhyReportIsOlder(const std::string& folder) {
  try {
    OpenedProject opened = Open(folder);
    const Plan plan(opened.graph(), opened.workshop(), {});
    opened.workshop().hasher.Save();
    for (int i = 0; i < plan.size(); ++i) {
      const Step& step = opened.graph().steps[i];
      const bool makes_it =
          std::any_of(step.results.begin(), step.results.end(), [](const NamedResult& result) {
            return result.path == "report" || result.path == fs::path("report") / "index.html";
          });
      if (makes_it && plan[i].state != StepPlan::State::kDone)
        return fmt::format("{} {}; `keypose run` brings it up to date", step.id,
                           plan[i].state == StepPlan::State::kReady
                               ? "would run again"
                               : "waits for " + Some(plan.WaitsFor(i)));
    }
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

ExitCode ReportCommand(const std::string& folder) {
  const fs::path report = FindProject(folder) / "out" / "report" / "index.html";
  if (!fs::exists(report))
    throw InputError("there is no report yet; `keypose run` makes " + report.string());
  fmt::print("{}\n", report.string());
  std::fflush(stdout);
  const std::string older = WhyReportIsOlder(folder);
  if (!older.empty())
    fmt::print(stderr, "keypose: this report is not of the present project: {}\n", older);
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
