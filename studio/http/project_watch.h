// Notices changes of the project's files that others make: an editor, a run, a file manager.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace keypose::studio {

class ProjectWatch {
 public:
  /// @param changed  called from the watch's own thread
  ProjectWatch(std::filesystem::path project, std::function<void()> changed);
  ~ProjectWatch();
  /// What the studio itself has just changed is no news.
  void Forget();

 private:
  std::string Look() const;
  void Watch();

  const std::filesystem::path project_;
  const std::function<void()> changed_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::string seen_;
  bool end_ = false;
  std::thread thread_;
};

}  // namespace keypose::studio
