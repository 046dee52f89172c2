#include "pipeline/run/builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "core/values/size_of.h"
#include "pipeline/run/collect_ending.h"
#include "pipeline/run/work_size.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

/// Maps a process's exit code, in the shell's convention, to an ExitCode.
ExitCode CodeOf(int raw) {
  switch (raw) {
    case 1:
    case 2:
    case 3:
    case 4:
    case 5:
    case 6:
    case 7:
    case 130:
      return static_cast<ExitCode>(raw);
    default:
      return raw > 128 ? ExitCode::kBug : ExitCode::kTool;
  }
}

/// Why a step failed, in words.
const char* WordsOf(ExitCode code) {
  switch (code) {
    case ExitCode::kUsage:
      return "an option is wrong";
    case ExitCode::kInput:
      return "what it was given cannot be used";
    case ExitCode::kDisk:
      return "a file, the disk or the memory";
    case ExitCode::kTool:
      return "a program or solver that it needs";
    case ExitCode::kQuality:
      return "its result is not good enough";
    default:
      return "a fault in its program";
  }
}

/// Without "keypose capture: error: " before a line: the step is named already.
std::string WithoutProgram(const std::string& said) {
  const std::string mark = ": error: ";
  std::string text;
  std::istringstream in(said);
  for (std::string line; std::getline(in, line);) {
    const auto at = line.find(mark);
    const bool named = line.starts_with("keypose ") && at != std::string::npos;
    text += (text.empty() ? "" : "\n") + (named ? line.substr(at + mark.size()) : line);
  }
  return text;
}

std::string LastLines(const std::string& text, int count) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) lines.push_back(line);
  }
  std::string result;
  for (std::size_t i = lines.size() > static_cast<std::size_t>(count)
                           ? lines.size() - static_cast<std::size_t>(count)
                           : 0;
       i < lines.size(); ++i) {
    result += (result.empty() ? "" : "\n") + lines[i];
  }
  return result;
}

}  // namespace

std::string FolderName(const std::string& step_id) {
  std::string name = step_id;
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

Builder::Builder(Plan& plan, Workshop& workshop, ProcessRunner& processes, const Clock& clock,
                 ResultsFolder& results, RunObserver& observer, const Limits& limits)
    : plan_(plan),
      workshop_(workshop),
      processes_(processes),
      clock_(clock),
      watch_(plan, workshop),
      results_(results),
      observer_(observer),
      limits_(limits),
      reported_(static_cast<std::size_t>(plan.size()), false) {}

fs::path Builder::WorkFolder(int step) const {
  return workshop_.state() / "tmp" / FolderName(plan_.graph().steps[step].id);
}

fs::path Builder::FailedFolder(int step) const {
  return workshop_.state() / "failed" / FolderName(plan_.graph().steps[step].id);
}

RunResult Builder::Run(RunRecord record) {
  record_ = std::move(record);
  record_.begin = clock_.Now();
  // Leftovers of an earlier run. The project is locked, so no other process uses them.
  workshop_.disk.Remove(workshop_.state() / "tmp");
  observer_.Begin(MakeForecast());
  try {
    Loop();
    if (!result_.again) EndRun();
    results_.Save();
    workshop_.hasher.Save();
    workshop_.disk.Remove(workshop_.state() / "tmp");
    SaveRecord();
  } catch (const Error& error) {
    processes_.StopAll();
    workshop_.disk.Remove(workshop_.state() / "tmp");
    // On a full disk the records cannot be written either; the step's own failure explains more.
    if (result_.code == ExitCode::kOk) throw;
  }
  return result_;
}

/// An interrupted run shows no warnings, verdicts or results.
void Builder::EndRun() {
  if (result_.code != ExitCode::kInterrupted)
    record_.ending = EndingOf(plan_, workshop_.disk, results_.out());
  observer_.End(record_.ending);
}

/// From the step's own last run, else from the last run of the same rule on another pose, else from
/// the step's `cost` in the pipeline file.
Forecast Builder::MakeForecast() const {
  const auto& steps = plan_.graph().steps;
  const auto may_run = [&](int i) {
    return plan_[i].wanted && plan_[i].state != StepPlan::State::kDone;
  };
  std::map<std::string, double> of_rule;
  std::map<std::string, int> side_by_side;
  const auto known = [&](int i) { return plan_[i].last && !plan_[i].last->fingerprint.empty(); };
  for (int i = 0; i < plan_.size(); ++i) {
    const std::string& rule = steps[i].rule;
    if (known(i)) of_rule[rule] = plan_[i].last->seconds;
    side_by_side[rule] += may_run(i);
  }
  Forecast forecast;
  forecast.cores = limits_.cores;
  forecast.load = limits_.load;
  WorkSize size(plan_.graph(), workshop_.disk, workshop_.project);
  for (int i = 0; i < plan_.size(); ++i) {
    if (!may_run(i)) continue;
    const Step& step = steps[i];
    Expected& expected = forecast.steps[step.id];
    expected.threads = std::max(1, limits_.cores / side_by_side[step.rule]);
    if (step.info->cores > 0) expected.threads = std::min(expected.threads, step.info->cores);
    for (const int need : step.needs) expected.needs.push_back(steps[need].id);
    const auto sibling = of_rule.find(step.rule);
    if (known(i)) {
      expected.from = Expected::From::kOwnRun;
      expected.seconds = plan_[i].last->seconds;
    } else if (sibling != of_rule.end()) {
      expected.from = Expected::From::kSibling;
      expected.seconds = sibling->second;
    } else if (const double work = size.CoreSeconds(i); work >= 0) {
      expected.from = Expected::From::kCost;
      expected.seconds = work / expected.threads;
    }
  }
  return forecast;
}

void Builder::Loop() {
  for (const std::string& note : results_.DropStepsOutside(plan_.graph())) observer_.Note(note);
  for (int i = 0; i < plan_.size(); ++i) {
    if (!plan_[i].wanted) continue;
    for (const std::string& warning : plan_.graph().steps[i].warnings)
      observer_.Note("warning: " + warning);
  }
  for (;;) {
    if (processes_.interrupted()) return Interrupt();
    ReportCached();
    if (result_.code == ExitCode::kOk && !result_.again) StartReady();
    if (running_.empty() && !processes_.interrupted()) return;
    for (const ProcessEvent& event : processes_.Wait(0.2)) Handle(event);
    observer_.Tick();
  }
}

void Builder::ReportCached() {
  for (int i = 0; i < plan_.size(); ++i) {
    if (plan_[i].state != StepPlan::State::kDone || reported_[i] || !plan_[i].wanted) continue;
    Adopt(i, false, 0, 0);
    ++result_.cached;
  }
}

/// Called when a step's artifact is in the cache: publishes its named results and records its
/// recipe.
void Builder::Adopt(int step, bool made, double seconds, std::int64_t peak_bytes) {
  reported_[step] = true;
  const Step& what = plan_.graph().steps[step];
  const StepPlan& plan = plan_[step];
  Publish(step);
  if (made || !plan.last || plan.last->failed || plan.last->fingerprint != plan.fingerprint) {
    StepRecord record;
    record.fingerprint = plan.fingerprint;
    record.recipe = plan.recipe;
    record.seconds = plan.artifact->seconds;
    record.peak_bytes = plan.artifact->peak_bytes;
    record.when = clock_.Now();
    record.reasons = plan.reasons;
    record.found = !made;
    if (!made && plan.last && !plan.last->fingerprint.empty())
      record.reasons = Differences(plan.last->recipe, plan.recipe);
    workshop_.records.SetLast(what.id, record);
  }
  AddToRecord(step, made ? "made" : "cached", seconds, peak_bytes);
  observer_.Finished(what.id, made ? "made" : "cached", seconds);
}

/// Another program may damage the artifact after it was looked at, and before or while it is
/// copied.
void Builder::Publish(int step) {
  const Step& what = plan_.graph().steps[step];
  const StepPlan& plan = plan_[step];
  const ResultsFolder::Published published = results_.Publish(what, *plan.artifact);
  for (const std::string& note : published.notes) observer_.Note(note);
  std::string damage = "it went away";
  if (!published.copied || workshop_.store.Find(plan.fingerprint, &damage)) return;
  results_.RemoveWrongCopies(what.id);
  observer_.Note(
      fmt::format("warning: while the results of {} were copied, its artifact in the cache was "
                  "damaged ({}); it is made again",
                  what.id, damage));
  result_.again = true;
}

void Builder::AddToRecord(int step, const std::string& status, double seconds,
                          std::int64_t peak_bytes) {
  record_.steps.push_back({plan_.graph().steps[step].id, status, plan_[step].fingerprint, seconds,
                           peak_bytes, plan_[step].reasons});
}

std::int64_t Builder::MemoryOf(int step) const {
  const StepPlan& plan = plan_[step];
  // The peak of the last run plus a margin is a better estimate than the stage's own figure.
  if (plan.last && plan.last->peak_bytes > 0)
    return plan.last->peak_bytes + plan.last->peak_bytes / 4;
  return plan_.graph().steps[step].info->memory_bytes;
}

bool Builder::MayStart(int step, std::int64_t memory) const {
  if (running_.empty()) return true;
  int threads = 0;
  std::int64_t used = 0;
  for (const auto& [id, running] : running_) {
    threads += running.threads;
    used += running.memory_bytes;
    // When two steps make the same artifact, the second waits and then finds it in the cache.
    if (plan_[running.step].fingerprint == plan_[step].fingerprint) return false;
  }
  return threads < limits_.cores &&
         (limits_.memory_bytes <= 0 || used + memory <= limits_.memory_bytes);
}

/// An equal share of the free cores; cores that a step cannot use go to the others.
int Builder::ThreadsFor(int step, int ready) const {
  int free = limits_.cores;
  for (const auto& [id, running] : running_) free -= running.threads;
  const int usable = plan_.graph().steps[step].info->cores;
  const int share = std::max(1, free / std::max(1, ready));
  return usable > 0 ? std::min(usable, share) : share;
}

void Builder::StartReady() {
  const auto is_running = [&](int step) {
    return std::any_of(running_.begin(), running_.end(),
                       [&](const auto& entry) { return entry.second.step == step; });
  };
  for (;;) {
    std::vector<int> ready = plan_.Ready();
    std::erase_if(ready, is_running);
    bool found_in_cache = false;
    int waiting = SizeOf(ready);
    for (const int step : ready) {
      // Another step of this run may have made the same artifact in the meantime.
      if (auto artifact =
              plan_[step].forced ? std::nullopt : workshop_.store.Find(plan_[step].fingerprint)) {
        plan_.SetDone(step, std::move(*artifact), false);
        found_in_cache = true;
        continue;
      }
      if (MayStart(step, MemoryOf(step))) Start(step, ThreadsFor(step, waiting));
      --waiting;
      if (result_.code != ExitCode::kOk) return;
    }
    if (!found_in_cache) return;
    ReportCached();
  }
}

std::vector<fs::path> Builder::PathsOf(const Flow& flow, const PortFlows& port, int step) {
  const fs::path inputs = WorkFolder(step) / "inputs" / port.port;
  if (flow.kind == Flow::Kind::kTimeline) {
    workshop_.disk.Write(inputs / "timeline.json", plan_.graph().timeline_json);
    return {inputs / "timeline.json"};
  }
  if (flow.kind == Flow::Kind::kRun) {
    workshop_.disk.Write(inputs / "run.json", plan_.RunJson(step));
    return {port.kind == PortKind::kFolder ? inputs : inputs / "run.json"};
  }
  return {plan_.SourceOf(flow)};
}

std::vector<std::string> Builder::ArgumentsOf(int step) {
  const Step& what = plan_.graph().steps[step];
  const fs::path made = WorkFolder(step) / "made";
  std::vector<std::string> arguments = {what.program.string()};
  const auto add = [&](const std::string& flag, const std::string& value) {
    arguments.push_back("--" + flag);
    arguments.push_back(value);
  };
  for (const PortFlows& port : what.inputs) {
    for (const Flow& flow : port.flows) {
      for (const fs::path& path : PathsOf(flow, port, step)) add(port.port, path.string());
    }
  }
  for (const PortInfo& port : what.info->outputs) add(port.name, (made / port.file).string());
  for (const auto& [name, value] : what.options) add(name, value);
  add("report", (made / "report.json").string());
  return arguments;
}

void Builder::Start(int step, int threads) {
  const Step& what = plan_.graph().steps[step];
  Running running{step, threads, MemoryOf(step), clock_.Now()};
  try {
    running.before = watch_.Look(step);
    workshop_.disk.Remove(WorkFolder(step));
    workshop_.disk.MakeFolder(WorkFolder(step) / "made");
    workshop_.disk.MakeFolder(WorkFolder(step) / "scratch");
    Command command;
    command.arguments = ArgumentsOf(step);
    command.environment = {fmt::format("KEYPOSE_THREADS={}", threads),
                           "TMPDIR=" + (WorkFolder(step) / "scratch").string()};
    command.folder = WorkFolder(step) / "scratch";
    command.log = WorkFolder(step) / "made" / "log.txt";
    running_[processes_.Start(command)] = running;
  } catch (const Error& error) {
    return Fail(running, static_cast<int>(error.code()), error.what());
  }
  observer_.Started(what.id, plan_[step].reasons, threads);
}

void Builder::Handle(const ProcessEvent& event) {
  const auto it = running_.find(event.id);
  if (it == running_.end()) return;
  const Running running = it->second;
  if (event.kind == ProcessEvent::Kind::kProgress) {
    observer_.Progressed(plan_.graph().steps[running.step].id, event.fraction, event.what);
    return;
  }
  running_.erase(it);
  if (processes_.interrupted())
    return;  // it ended because the run is being stopped, or just before; in both cases it is not
             // kept
  try {
    // Checked for failed steps too: the cause may be a photograph that was still being written and
    // is complete now.
    if (WasSpoilt(running)) return;
    if (event.exit_code != 0) return Fail(running, event.exit_code, "");
    Succeed(running, event.peak_bytes);
  } catch (const Error& error) {
    Fail(running, static_cast<int>(error.code()), error.what());
  }
}

/// Whether an input may have changed while the step ran, so that its fingerprint is wrong. If so,
/// the step's results are dropped and its inputs are hashed again.
bool Builder::WasSpoilt(const Running& running) {
  const std::string changed = watch_.Changed(running.step, running.before);
  if (changed.empty()) return false;
  const std::string& id = plan_.graph().steps[running.step].id;
  workshop_.disk.Remove(WorkFolder(running.step));
  AddToRecord(running.step, "spoilt", clock_.Now() - running.begin, 0);
  observer_.Finished(id, "spoilt", clock_.Now() - running.begin);
  observer_.Note(fmt::format("warning: while {} ran, {}; nothing of it was kept, and it runs again",
                             id, changed));
  result_.again = true;
  return true;
}

void Builder::Succeed(const Running& running, std::int64_t peak_bytes) {
  const Step& what = plan_.graph().steps[running.step];
  const double seconds = clock_.Now() - running.begin;
  Artifact artifact = workshop_.store.Commit(WorkFolder(running.step) / "made", *what.info,
                                             plan_[running.step].recipe, seconds, peak_bytes);
  workshop_.disk.Remove(WorkFolder(running.step));
  workshop_.disk.Remove(FailedFolder(running.step));
  plan_.SetDone(running.step, std::move(artifact), true);
  ++result_.made;
  Adopt(running.step, true, seconds, peak_bytes);
  SaveRecord();
}

namespace {

void Replace(const std::string& from, const std::string& to, std::string* text) {
  for (std::size_t at = text->find(from); at != std::string::npos; at = text->find(from, at)) {
    text->replace(at, from.size(), to);
    at += to.size();
  }
}

}  // namespace

/// Keeps the log of a failed step, and pictures that its program left to show why
/// (core/stage/failure_picture.h).
/// @param said  what is shown of it; the places of these pictures are corrected in it and in the
/// log
void Builder::KeepOfFailure(int step, std::string& said) {
  const fs::path made = WorkFolder(step) / "made", kept = FailedFolder(step);
  if (!workshop_.disk.Stat(made / "log.txt")) return;
  if (said.empty())
    said = WithoutProgram(LastLines(workshop_.disk.ReadEnd(made / "log.txt", 1 << 16), 6));
  workshop_.disk.Remove(kept);
  workshop_.disk.Move(made / "log.txt", kept / "log.txt");
  for (const std::string& name : workshop_.disk.Children(made)) {
    if (!name.ends_with(".failed.jpg")) continue;
    workshop_.disk.Move(made / name, kept / name);
    std::string log = workshop_.disk.Read(kept / "log.txt");
    for (std::string* text : {&said, &log})
      Replace((made / name).string(), (kept / name).string(), text);
    workshop_.disk.Write(kept / "log.txt", log);
  }
}

void Builder::Fail(const Running& running, int raw_code, const std::string& message) {
  const Step& what = plan_.graph().steps[running.step];
  const ExitCode code = CodeOf(raw_code);
  std::string said = message;
  try {
    KeepOfFailure(running.step, said);
    workshop_.disk.Remove(WorkFolder(running.step));
    StepRecord record = plan_[running.step].last.value_or(StepRecord{});
    record.failed = true;
    record.exit_code = static_cast<int>(code);
    record.failed_fingerprint = plan_[running.step].fingerprint;
    record.error = said;
    record.when = clock_.Now();
    workshop_.records.SetLast(what.id, record);
  } catch (const Error& error) {
    // for example on a full disk; only the first failure is reported as such
    said += fmt::format("\n(and its log could not be kept: {})", error.what());
  }
  AddToRecord(running.step, "failed", clock_.Now() - running.begin, 0);
  observer_.Finished(what.id, "failed", clock_.Now() - running.begin);
  if (result_.code != ExitCode::kOk) return;
  result_.code = code;
  result_.message = FailureMessage(running.step, code, raw_code, said);
}

std::string Builder::FailureMessage(int step, ExitCode code, int raw_code,
                                    const std::string& said) const {
  const std::string& id = plan_.graph().steps[step].id;
  std::string message = fmt::format("{} failed: {}", id, WordsOf(code));
  if (raw_code > 128 && code == ExitCode::kBug) {
    message += fmt::format(": it was ended by signal {}", raw_code - 128);
    if (raw_code == 128 + 9)
      message += " (killed: perhaps the machine ran out of memory; try a smaller -j)";
  } else if (raw_code == 127) {
    message += ": the program could not be started";
  } else if (code == ExitCode::kDisk && said.empty()) {  // on a full disk the log is empty too
    message +=
        ": a file could not be read or written, and no log could be kept; is there free space on "
        "the disk?";
  }
  message += "\n" + said;
  const fs::path log = FailedFolder(step) / "log.txt";
  if (workshop_.disk.Stat(log))
    message += fmt::format("\nits whole log: {} (or `keypose log {}`)", log.string(), id);
  message += "\nwhen that is fixed, `keypose run` continues from here; earlier results are kept";
  return message;
}

void Builder::Interrupt() {
  processes_.StopAll();
  for (const auto& [id, running] : running_) {
    AddToRecord(running.step, "interrupted", clock_.Now() - running.begin, 0);
    observer_.Finished(plan_.graph().steps[running.step].id, "interrupted",
                       clock_.Now() - running.begin);
  }
  running_.clear();
  result_.code = ExitCode::kInterrupted;
  result_.message = "interrupted; earlier results are kept, and `keypose run` continues from here";
}

void Builder::SaveRecord() {
  record_.end = clock_.Now();
  record_.exit_code = static_cast<int>(result_.code);
  workshop_.records.Save(record_);
}

}  // namespace keypose::pipeline
