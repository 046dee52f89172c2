// The studio's first page: which projects there are, and which is open.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "studio/http/answers.h"
#include "studio/routes/routes.h"
#include "studio/runs/example_maker.h"

namespace keypose::studio {

struct DoorOptions {
  std::filesystem::path home;                ///< where new projects are made
  std::filesystem::path state;               ///< of UserStateFolder; empty: nothing is remembered
  std::filesystem::path programs;            ///< of Keypose, which draw examples
  std::function<std::string()> new_address;  ///< one that lets one more browser in
  std::function<void()> end;                 ///< ends the studio
};

class Door {
 public:
  explicit Door(DoorOptions options);

  /// What the tabs of another project ask goes to this one from now on; they load it by themselves.
  void Open(const std::filesystem::path& folder);
  /// The open project; null: none.
  std::shared_ptr<Routes> Now() const;
  std::filesystem::path Folder() const;
  /// What pages send back with each change, so that none meant for another project is made; "":
  /// none is open.
  std::string Mark() const;
  /// Puts the open project first in the person's list, once there is a project.
  void RememberIt();

  /// Of an address that begins with /api/door. Never throws.
  Answer Handle(const Question& question);

 private:
  Answer HandleOrThrow(const Question& question);
  Answer Look(const Question& question);
  nlohmann::json StateJson() const;
  void TakeExample(const std::filesystem::path& folder, bool runs);

  const DoorOptions options_;
  mutable std::mutex mutex_, list_mutex_;
  std::filesystem::path folder_;
  std::shared_ptr<Routes> routes_;
  std::atomic<bool> remembered_ = false;
  ExampleMaker examples_;
};

}  // namespace keypose::studio
