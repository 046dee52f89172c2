// Example projects, drawn by `keypose synth` on this machine: no network, no files that come along.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace keypose::studio {

/// finished: a character of one pose all round and six photographs of another, whose steps run;
/// six: the same, to be run; two: two poses all round; film: a filmed shot; dance: a performance;
/// puppet: a puppet of wire. Each is also the name of its folder.
const std::vector<std::string>& ExampleKinds();

struct ExampleState {
  std::string kind;  ///< empty: none was asked for yet
  std::filesystem::path folder;
  bool at_work = false;
  double share = 0;   ///< of the work that is done, 0 to 1
  std::string words;  ///< what is being made
  std::string error;  ///< why it was not made
};

class ExampleMaker {
 public:
  /// @param programs  folder of Keypose's programs
  /// @param made      called from another thread with each example's folder; `runs`: its steps
  /// shall
  ///                  run now
  ExampleMaker(std::filesystem::path programs,
               std::function<void(const std::filesystem::path&, bool runs)> made);
  /// What is not made by then is given up, and removed.
  ~ExampleMaker();

  /// Makes it in `base`/`kind`. @throws LockedError  another one is being made
  /// @throws UsageError  no such kind, or the folder has files @throws DiskError
  void Start(const std::string& kind, const std::filesystem::path& base);
  void Stop() { stop_ = true; }
  ExampleState State() const;

 private:
  void Make(const std::string& kind, const std::filesystem::path& folder);
  bool Run(const std::vector<std::string>& command, const std::filesystem::path& folder,
           double from, double to);
  void Set(const std::function<void(ExampleState&)>& change);

  const std::filesystem::path programs_;
  const std::function<void(const std::filesystem::path&, bool)> made_;
  mutable std::mutex mutex_;
  ExampleState state_;
  std::atomic<bool> stop_ = false;
  std::thread worker_;
};

}  // namespace keypose::studio
