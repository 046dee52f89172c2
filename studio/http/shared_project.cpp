#include "studio/http/shared_project.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/values/errors.h"
#include "pipeline/cache/project_lock.h"
#include "studio/project/moves.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Editors often empty a file before they write it: what cannot be read is read again a moment
/// later.
std::unique_ptr<Snapshot> OpenSnapshot(const fs::path& folder) {
  constexpr int kTries = 3;
  for (int i = 1; i < kTries; ++i) {
    try {
      return std::make_unique<Snapshot>(folder);
    } catch (const Error&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  return std::make_unique<Snapshot>(folder);
}

}  // namespace

SharedProject::SharedProject(fs::path folder) : folder_(std::move(folder)) {
  UndoBrokenMoves(folder_);
  Follow();
}

SharedProject::~SharedProject() {
  watch_.reset();
  run_.reset();
  hub_.Close();
}

bool SharedProject::Exists() const { return fs::is_regular_file(folder_ / "pipeline.yaml"); }

std::string SharedProject::LockedBy() {
  if (run_->running()) return "";
  return pipeline::LockHolder(folder_ / ".keypose");
}

/// Follows the runs and files of the project, also of one that is made later.
void SharedProject::Follow() {
  RunControl::Listener listener;
  listener.line = [this](const std::string& line) {
    stale_ = true;
    hub_.Send("run", line);
  };
  listener.ended = [this](int code, const std::string& message) {
    stale_ = true;
    hub_.Send("run_ended", json{{"exit_code", code}, {"message", message}}.dump());
  };
  run_ = std::make_unique<RunControl>(folder_, listener);
  watch_ = std::make_unique<ProjectWatch>(folder_, [this] {
    stale_ = true;
    hub_.Send("project", "{}");
  });
  if (Exists()) run_->TakeUp();
}

void SharedProject::TellOfOwnChange() {
  stale_ = true;
  watch_->Forget();
  hub_.Send("project", "{}");
}

Snapshot& SharedProject::Now() {
  if (!Exists()) throw UsageError("there is no project in this folder yet");
  if (stale_.exchange(false)) snapshot_.reset();
  if (!snapshot_) snapshot_ = OpenSnapshot(folder_);
  return *snapshot_;
}

Snapshot& SharedProject::ReadAgain() {
  stale_ = true;
  return Now();
}

}  // namespace keypose::studio
