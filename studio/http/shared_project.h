// The project as all pages see it: read again when it has changed, and changed by one caller at a
// time; its run; the events that tell open tabs of both.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "studio/http/event_hub.h"
#include "studio/http/project_watch.h"
#include "studio/project/snapshot.h"
#include "studio/runs/run_control.h"

namespace keypose::studio {

class SharedProject {
 public:
  /// @param folder  of the project, or where one is to be made
  explicit SharedProject(std::filesystem::path folder);
  ~SharedProject();

  const std::filesystem::path& folder() const { return folder_; }
  /// Where small pictures are kept.
  std::filesystem::path PictureFolder() const { return folder_ / ".keypose/studio/pictures"; }
  bool Exists() const;

  /// Calls `use` with the project as it is now; one caller at a time.
  /// @throws UsageError  there is no project yet
  template <class Use>
  auto With(const Use& use) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return use(Now());
  }
  /// The same without a plan, which there may not be yet.
  template <class Use>
  auto WithFolder(const Use& use) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return use(folder_);
  }
  /// The project as `use` has just changed it, and not as another caller will. @pre within With
  Snapshot& ReadAgain();

  /// The next caller reads it again.
  void Forget() { stale_ = true; }
  /// Likewise; and the other tabs are told at once of what this studio has changed.
  void TellOfOwnChange();

  EventHub& hub() { return hub_; }
  RunControl& run() { return *run_; }
  /// Words on another program that runs the project, or "".
  std::string LockedBy();

 private:
  Snapshot& Now();
  void Follow();

  const std::filesystem::path folder_;
  EventHub hub_;
  std::mutex mutex_;
  std::unique_ptr<Snapshot> snapshot_;  ///< null: read again
  std::atomic<bool> stale_ = true;
  std::unique_ptr<RunControl> run_;
  std::unique_ptr<ProjectWatch> watch_;
};

}  // namespace keypose::studio
