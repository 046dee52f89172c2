#include "studio/project/left_out_photographs.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/left_out.h"
#include "pipeline/graph/figure_setting.h"
#include "studio/project/changes.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Step;

namespace {

/// The step that reads a pose's photographs; null: it is a mesh made elsewhere, or switched off.
const Step* ReadingStep(const Snapshot& snapshot, const std::string& pose) {
  for (const Step& step : snapshot.graph().steps)
    if (step.pose == pose && step.info->stage == "capture" &&
        step.options.contains(kLeaveOutOption))
      return &step;
  return nullptr;
}

/// A photograph's file, and how capture would call it.
struct Shot {
  fs::path below;
  std::string written;
};

Shot ShotOf(const Snapshot& snapshot, const Originals& originals, const std::string& pose,
            const std::string& name) {
  const fs::path file = originals.FileOf(name);
  if (file.empty()) throw UsageError(fmt::format("pose '{}' has no photograph '{}'", pose, name));
  const fs::path below = file.lexically_relative(snapshot.PhotoFolder(pose));
  const std::string group = below.parent_path().filename();
  return {below, (group.empty() ? "" : group + "_") + WrittenName(file)};
}

bool Means(const std::string& name, const Shot& shot) {
  return MeansPhotograph(name, shot.below, shot.written);
}

}  // namespace

std::vector<std::string> LeftOutNames(const Snapshot& snapshot, const std::string& pose) {
  const Step* step = ReadingStep(snapshot, pose);
  return step ? ParseLeftOut(step->options.at(kLeaveOutOption)) : std::vector<std::string>();
}

std::vector<std::string> LeftOutAmong(Snapshot& snapshot, const std::string& pose,
                                      const std::vector<std::string>& names) {
  const std::vector<std::string> all = LeftOutNames(snapshot, pose);
  if (all.empty()) return {};
  const Originals originals(snapshot, pose);
  std::vector<std::string> out;
  for (const std::string& name : names) {
    const Shot shot = ShotOf(snapshot, originals, pose, name);
    if (std::any_of(all.begin(), all.end(), [&](const auto& one) { return Means(one, shot); }))
      out.push_back(name);
  }
  return out;
}

std::string WithLeftOut(Snapshot& snapshot, const std::string& text, const std::string& pose,
                        const std::vector<std::string>& names, bool out) {
  if (names.empty()) return text;
  const Step* step = ReadingStep(snapshot, pose);
  if (!step)
    throw UsageError(
        fmt::format("nothing reads the photographs of '{}' (is its step capture "
                    "switched off?), so none can be left out",
                    pose));
  std::vector<std::string> all = ParseLeftOut(step->options.at(kLeaveOutOption));
  const Originals originals(snapshot, pose);
  for (const std::string& name : names) {
    const Shot shot = ShotOf(snapshot, originals, pose, name);
    std::erase_if(all, [&](const std::string& one) { return Means(one, shot); });
    if (out) all.push_back(shot.below.generic_string());
  }
  const YamlPath below = {"options", step->rule, kLeaveOutOption};
  const auto for_all = snapshot.file().options.find(step->rule);
  const bool stays_for_all =
      for_all != snapshot.file().options.end() && for_all->second.options.contains(kLeaveOutOption);
  return Edited([&] {
    if (all.empty() && !stays_for_all)
      return pipeline::WithoutPoseSetting(snapshot.file(), text, pose, below);
    return WithPoseSetting(snapshot, text, pose, below, YamlScalar(LeftOutText(all)));
  });
}

void LeaveOut(Snapshot& snapshot, const std::string& pose, const std::vector<std::string>& names,
              bool out) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  const fs::path file = snapshot.project() / "pipeline.yaml";
  const std::string revision = RevisionOf(file), text = ReadFile(file);
  const std::string edited = WithLeftOut(snapshot, text, pose, names, out);
  if (edited != text) WritePipelineFile(snapshot.project(), edited, revision);
}

json AgainJson(Snapshot& snapshot, const std::string& pose) {
  return AgainAfter(snapshot, ReadingStep(snapshot, pose));
}

json AgainAfter(Snapshot& snapshot, const Step* step) {
  json again = {{"step", ""}, {"follow", json::array()}, {"seconds", 0.0}, {"made", false}};
  if (!step) return again;
  double seconds = 0;
  bool made = false;
  const auto add = [&](const Step& one) {
    const auto i = static_cast<int>(&one - snapshot.graph().steps.data());
    if (const auto& last = snapshot.plan()[i].last; last && !last->failed) {
      seconds += last->seconds;
      made = true;
    }
  };
  add(*step);
  for (const Step* after : pipeline::StepsThatFollow(snapshot.graph(), *step)) {
    again["follow"].push_back(after->id);
    add(*after);
  }
  again["step"] = step->id;
  again["seconds"] = seconds;
  again["made"] = made;
  return again;
}

}  // namespace keypose::studio
