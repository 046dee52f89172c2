#include "core/stage/stage_context.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/stage/output_guard.h"
#include "core/values/errors.h"

namespace keypose::internal {
namespace fs = std::filesystem;

RunningStage::RunningStage(const StageSpec& spec, PortPaths inputs, PortPaths outputs,
                           Placing placing, Progress* progress)
    : spec_(spec),
      inputs_(std::move(inputs)),
      outputs_(std::move(outputs)),
      placing_(placing),
      progress_(progress) {}

RunningStage::~RunningStage() { RemoveTemporaries(); }

void RunningStage::RemoveTemporaries() {
  std::error_code ignored;
  for (const Pending& pending : pending_) fs::remove_all(pending.temporary_folder, ignored);
  if (!scratch_.empty()) fs::remove_all(scratch_, ignored);
}

bool RunningStage::Has(std::string_view port) const {
  return inputs_.find(port) != inputs_.end() || outputs_.find(port) != outputs_.end();
}

fs::path RunningStage::Input(std::string_view port) const {
  const auto it = inputs_.find(port);
  return it == inputs_.end() ? fs::path() : it->second.front();
}

std::vector<fs::path> RunningStage::Inputs(std::string_view port) const {
  const auto it = inputs_.find(port);
  return it == inputs_.end() ? std::vector<fs::path>() : it->second;
}

fs::path RunningStage::Output(std::string_view port) {
  const std::lock_guard lock(mutex_);
  for (const Pending& pending : pending_)
    if (pending.port == port) return pending.temporary;
  const auto it = outputs_.find(port);
  if (it == outputs_.end()) return {};
  Pending pending;
  pending.port = port;
  for (const Port& p : spec_.outputs) pending.is_folder |= p.name == port && p.kind == "folder";
  pending.final_path = PlaceOf(it->second.front(), pending.is_folder);
  const fs::path parent = pending.final_path.parent_path();
  std::error_code error;
  fs::create_directories(parent, error);
  pending.temporary_folder =
      parent / fmt::format(".partial-{}-{}-{}", spec_.name, port, ::getpid());
  fs::create_directories(pending.temporary_folder, error);
  if (error)
    throw DiskError(fmt::format("{}: cannot create a folder in {}: {}", spec_.name, parent.string(),
                                error.message()));
  pending.temporary = pending.temporary_folder / pending.final_path.filename();
  if (pending.is_folder) fs::create_directories(pending.temporary);
  pending_.push_back(pending);
  return pending.temporary;
}

fs::path RunningStage::Scratch() {
  const std::lock_guard lock(mutex_);
  if (scratch_.empty()) {
    // Next to the first output, so that large temporary files are on the disk that the user chose.
    const auto it = outputs_.begin();
    const fs::path parent = it == outputs_.end()
                                ? fs::temp_directory_path()
                                : fs::absolute(it->second.front()).lexically_normal().parent_path();
    std::error_code error;
    fs::create_directories(parent, error);
    scratch_ = parent / fmt::format(".scratch-{}-{}", spec_.name, ::getpid());
    fs::create_directories(scratch_, error);
    if (error)
      throw DiskError(
          fmt::format("{}: cannot create {}: {}", spec_.name, scratch_.string(), error.message()));
  }
  return scratch_;
}

void RunningStage::Report(std::string_view name, double value) {
  measurements_[std::string(name)] =
      std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

void RunningStage::ReportJson(std::string_view name, const std::string& text) {
  measurements_[std::string(name)] = nlohmann::json::parse(text);
}

void RunningStage::Note(const std::string& line) {
  std::fprintf(stderr, "%s: %s\n", spec_.name.c_str(), line.c_str());
  std::fflush(stderr);
}

void RunningStage::Warn(const std::string& sentence) {
  if (std::find(warnings_.begin(), warnings_.end(), sentence) != warnings_.end()) return;
  Note("warning: " + sentence);
  warnings_.push_back(sentence);
}

void RunningStage::Verdict(const std::string& about, const std::string& grade,
                           const std::string& why) {
  verdicts_.push_back({{"about", about}, {"grade", grade}, {"why", why}});
}

bool RunningStage::Abandon() {
  const std::lock_guard lock(mutex_);
  if (committed_) return false;
  RemoveTemporaries();
  return true;
}

void RunningStage::Commit() {
  const std::lock_guard lock(mutex_);
  committed_ = true;
  for (const Pending& pending : pending_) {
    if (!fs::exists(pending.temporary))
      throw std::logic_error(
          fmt::format("stage {} did not write its output '{}'", spec_.name, pending.port));
    CheckPlace(spec_, pending.final_path, pending.is_folder, placing_.overwrite);
    if (pending.is_folder && placing_.mark) MarkFolder(pending.temporary, spec_.name);
  }
  for (const Pending& pending : pending_) Place(pending);
  pending_.clear();
}

void RunningStage::Place(const Pending& pending) const {
  std::error_code error;
  const auto check = [&](const fs::path& what) {
    if (error)
      throw DiskError(fmt::format("{}: cannot put {} into place: {}", spec_.name, what.string(),
                                  error.message()));
  };
  // rename(2) does not replace a folder that is not empty. The old folder is moved aside first, so
  // that one of the two always exists.
  fs::path aside;
  if (pending.is_folder && fs::is_directory(pending.final_path)) {
    aside = pending.temporary_folder / ".old";
    fs::rename(pending.final_path, aside, error);
    check(pending.final_path);
  }
  fs::rename(pending.temporary, pending.final_path, error);
  if (error && !aside.empty()) {
    std::error_code ignored;
    fs::rename(aside, pending.final_path, ignored);
  }
  check(pending.final_path);
  // Additional files of a format, such as an OBJ's .mtl.
  for (const auto& entry : fs::directory_iterator(pending.temporary_folder)) {
    if (entry.path() == aside) continue;
    const fs::path companion = pending.final_path.parent_path() / entry.path().filename();
    fs::rename(entry.path(), companion, error);
    check(companion);
  }
  fs::remove_all(pending.temporary_folder, error);
}

}  // namespace keypose::internal
