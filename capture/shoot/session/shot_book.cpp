#include "capture/shoot/session/shot_book.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/shoot/develop/photograph.h"
#include "capture/shoot/session/shot_checks.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

std::string PlanText(const ShotPlan& plan) {
  std::string rings;
  for (const double ring : plan.rings_deg) rings += (rings.empty() ? "" : ",") + DegreesText(ring);
  return fmt::format("--rings {} --angles {} --flips {} --focus-stack {}", rings, plan.angles,
                     plan.flips, plan.focus_stack);
}

/// Further rings and flips may be added to a plan; what was shot keeps its names and angles.
bool Extends(const ShotPlan& plan, const ShotPlan& old) {
  const bool rings = plan.rings_deg.size() >= old.rings_deg.size() &&
                     std::equal(old.rings_deg.begin(), old.rings_deg.end(), plan.rings_deg.begin());
  return rings && plan.angles == old.angles && plan.flips >= old.flips;
}

}  // namespace

ShotBook::ShotBook(const fs::path& folder, const std::string& pose, const ShotPlan& plan,
                   bool plan_given)
    : store_(folder) {
  side_.pose = pose;
  side_.plan = plan;
  SideFile old;
  if (fs::exists(SidePath())) {
    old = ParseSideFile(ReadFile(SidePath()), SidePath().string());
    TakeOver(old, plan, plan_given);
  }
  for (const Shot& shot : AllShots(side_.plan)) {
    const fs::path file = store_.FileOf(Name(shot));
    if (file.empty()) continue;
    resumed_ = true;
    const auto known = old.photographs.find(shot);
    const bool same = known != old.photographs.end() &&
                      known->second.file == file.filename().string() &&
                      known->second.time == TimeOfFile(file);
    side_.photographs[shot] = same ? known->second : Measure(shot);
    side_.skipped.erase(shot);
    if (!same) ForgetRing(shot);
  }
  JudgeAll(&side_);
}

void ShotBook::TakeOver(const SideFile& old, const ShotPlan& plan, bool plan_given) {
  if (plan_given && !Extends(plan, old.plan))
    throw InputError(
        fmt::format("{} was begun with {}, and this is {}: leave these flags out to go on, or move "
                    "the folder away to begin anew",
                    SidePath().string(), PlanText(old.plan), PlanText(plan)));
  if (!plan_given) side_.plan = old.plan;
  side_.white = old.white;
  side_.rings = old.rings;
  side_.skipped = old.skipped;
}

NextThing ShotBook::Next() const {
  std::optional<Shot> first;
  const std::vector<Shot> shots = AllShots(side_.plan);
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const Shot& shot = shots[i];
    if (shot.index == 0) first = shot;
    if (!Has(shot) && !side_.skipped.contains(shot)) return {NextThing::Kind::kShoot, shot};
    const bool ring_ends = i + 1 == shots.size() || shots[i + 1].index == 0;
    const bool checked = side_.FindRing(shot.flip, shot.ring) != nullptr;
    if (ring_ends && !checked) return {NextThing::Kind::kCheckRing, *first};
  }
  return {};
}

PhotographEntry ShotBook::Measure(const Shot& shot) const {
  const std::string name = Name(shot);
  const fs::path file = store_.FileOf(name), raw = store_.RawOf(name);
  PhotographEntry entry;
  entry.shot = shot;
  entry.file = file.filename().string();
  if (!raw.empty() && raw != file) entry.raw = raw.filename().string();
  entry.time = TimeOfFile(file);
  try {
    const Measured measured = MeasurePhotograph(ReadPhotograph(file));
    entry.settings = ReadSettings(file);
    entry.width = measured.width;
    entry.height = measured.height;
    entry.crispness = measured.crispness;
    entry.sharpness = measured.sharpness;
    entry.exposure = measured.exposure;
    entry.light = measured.light;
    entry.clipped = measured.clipped;
    entry.mask_fraction = measured.mask_fraction;
    entry.touches_border = measured.touches_border;
  } catch (const InputError&) {
    entry.readable = false;  // a finding, and not the end of the session
  }
  return entry;
}

std::vector<Shot> ShotBook::Enter(const Shot& shot) {
  std::map<Shot, std::vector<Finding>> before;
  for (const auto& [other, entry] : side_.photographs) before[other] = entry.findings;
  side_.photographs[shot] = Measure(shot);
  side_.skipped.erase(shot);
  JudgeAll(&side_);
  std::vector<Shot> changed;
  for (const auto& [other, findings] : before)
    if (other != shot && side_.photographs[other].findings != findings) changed.push_back(other);
  return changed;
}

void ShotBook::Skip(const Shot& shot) {
  side_.skipped.insert(shot);
  JudgeAll(&side_);
}

void ShotBook::CheckRing(const Shot& first, std::optional<double> moved_px) {
  ForgetRing(first);
  side_.rings.push_back({first.flip, first.ring, moved_px, {}, {}});
  std::sort(side_.rings.begin(), side_.rings.end(), [](const RingEntry& a, const RingEntry& b) {
    return std::pair(a.flip, a.ring) < std::pair(b.flip, b.ring);
  });
  JudgeAll(&side_);
}

void ShotBook::ForgetRing(const Shot& shot) {
  if (shot.index != 0) return;
  std::erase_if(side_.rings, [&](const RingEntry& ring) {
    return ring.flip == shot.flip && ring.ring == shot.ring;
  });
}

void ShotBook::Save() const { WriteDurably(SidePath(), SideFileText(side_)); }

}  // namespace keypose::capture::shoot
