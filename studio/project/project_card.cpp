#include "studio/project/project_card.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/cache/project_lock.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/originals.h"
#include "studio/project/pose_photographs.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kCardWidth = 480;  // [px]

bool HasFailed(const pipeline::StepPlan& step) {
  return step.state == pipeline::StepPlan::State::kReady && step.last && step.last->failed &&
         step.last->failed_fingerprint == step.fingerprint;
}

/// Counts what is done; steps without their programs are not to be done.
json CardOf(Snapshot& now) {
  int done = 0, steps = 0, failed = 0;
  for (int i = 0; i < now.plan().size(); ++i) {
    const pipeline::StepPlan& step = now.plan()[i];
    if (step.state == pipeline::StepPlan::State::kMissing) continue;
    ++steps;
    if (step.state == pipeline::StepPlan::State::kDone) ++done;
    if (HasFailed(step)) ++failed;
  }
  const bool performance = now.graph().kind == pipeline::ProjectKind::kPerformance;
  const char* state = failed > 0 ? "failed" : done == 0 ? "new" : done == steps ? "done" : "begun";
  return {{"state", state},
          {"done", done},
          {"steps", steps},
          {"poses", now.file().poses.size()},
          {"kind", performance ? "performance" : "poses"},
          {"problem", ""}};
}

json PlainCard(const char* state, const std::string& problem) {
  return {{"state", state}, {"done", 0},       {"steps", 0},
          {"poses", 0},     {"kind", "poses"}, {"problem", problem}};
}

/// The first picture in a folder, by name; empty if there is none.
fs::path FirstPictureIn(const fs::path& folder) {
  std::error_code none;
  std::vector<fs::path> found;
  for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none)) {
    const std::string kind = LowerExtension(at->path());
    if ((kind == ".jpg" || kind == ".png") && at->is_regular_file(none)) found.push_back(*at);
  }
  return found.empty() ? fs::path() : *std::min_element(found.begin(), found.end());
}

/// The first photograph of the template, or of a performance the first frame that is a picture.
fs::path SourcePicture(const fs::path& folder) {
  Snapshot now(folder);
  if (now.graph().kind == pipeline::ProjectKind::kPerformance) {
    for (const std::string& shot : now.graph().poses) {
      std::error_code none;
      for (fs::directory_iterator at(now.PhotoFolder(shot), none), end; !none && at != end;
           at.increment(none))
        if (const fs::path found = FirstPictureIn(*at); !found.empty()) return found;
    }
    return {};
  }
  const fs::path photos = now.PhotoFolder(now.graph().template_pose);
  const auto names = OriginalPhotographs(photos);
  return names.empty() ? fs::path() : photos / names.front();
}

}  // namespace

json ProjectCardJson(const fs::path& folder) {
  if (!fs::is_regular_file(folder / "pipeline.yaml")) return PlainCard("empty", "");
  try {
    Snapshot now(folder);
    json card = CardOf(now);
    if (!pipeline::LockHolder(folder / ".keypose").empty()) card["state"] = "running";
    return card;
  } catch (const Error& error) {
    return PlainCard("broken", error.what());
  }
}

fs::path ProjectPicture(const fs::path& folder) {
  fs::path source;
  try {
    source = SourcePicture(folder);
  } catch (const Error&) {
    // the card says what is wrong
  }
  if (source.empty() || pipeline::RealDisk().LeadsOutside(source, source.parent_path()))
    throw NotFound("there is no picture yet");
  return PictureFile(folder / ".keypose/studio/pictures", source, kCardWidth);
}

}  // namespace keypose::studio
