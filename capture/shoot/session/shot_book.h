// A pose's photographs and their side file, kept together.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/shoot/record/side_file.h"
#include "capture/shoot/session/photograph_store.h"

namespace keypose::capture::shoot {

/// What a session does next for a pose.
struct NextThing {
  enum class Kind { kShoot, kCheckRing, kNothing };
  Kind kind = Kind::kNothing;
  Shot shot;  ///< to shoot; of a ring to be checked, its first angle
};

class ShotBook {
 public:
  /// Opens the pose's folder. Photographs without an entry are measured, entries without a
  /// photograph dropped.
  /// @param plan        what to shoot; a plan that was begun may only be extended
  /// @param plan_given  the person gave it; else the one of the side file goes on
  /// @throws InputError  a damaged side file, or one with another plan
  ShotBook(const std::filesystem::path& folder, const std::string& pose, const ShotPlan& plan,
           bool plan_given);

  SideFile& side() { return side_; }
  const SideFile& side() const { return side_; }
  PhotographStore& store() { return store_; }
  bool resumed() const { return resumed_; }
  const std::filesystem::path& folder() const { return store_.folder(); }

  NextThing Next() const;
  bool Has(const Shot& shot) const { return side_.photographs.contains(shot); }
  int Done() const { return static_cast<int>(side_.photographs.size()); }
  int Total() const { return static_cast<int>(AllShots(side_.plan).size()); }
  std::string Name(const Shot& shot) const { return NameOf(side_.plan, shot); }
  /// Whether everything of the plan is there, skipped or checked.
  bool Complete() const { return Next().kind == NextThing::Kind::kNothing; }

  /// Measures a photograph that has landed, and judges all anew.
  /// @return names of other photographs whose findings changed
  std::vector<Shot> Enter(const Shot& shot);
  void Skip(const Shot& shot);
  /// @param moved_px  nothing if the check was skipped
  void CheckRing(const Shot& first, std::optional<double> moved_px);
  /// A ring whose first angle is shot again must be checked again.
  void ForgetRing(const Shot& shot);
  /// @throws DiskError
  void Save() const;

 private:
  void TakeOver(const SideFile& old, const ShotPlan& plan, bool plan_given);
  PhotographEntry Measure(const Shot& shot) const;
  std::filesystem::path SidePath() const { return folder() / "shoot.json"; }

  PhotographStore store_;
  SideFile side_;
  bool resumed_ = false;
};

}  // namespace keypose::capture::shoot
