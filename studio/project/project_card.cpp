#include "studio/project/project_card.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "pipeline/cache/project_lock.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/films.h"
#include "studio/project/not_found.h"
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

/// Whether PictureOf finds one; draws none.
bool HasPicture(Snapshot& now) {
  const bool performance = now.graph().kind == pipeline::ProjectKind::kPerformance;
  if (!performance) return !OriginalPhotographs(now.PhotoFolder(now.graph().template_pose)).empty();
  return std::any_of(now.graph().poses.begin(), now.graph().poses.end(),
                     [&](const std::string& shot) {
                       return !FilmsIn(FilmFolder(now.project(), now.file(), shot)).empty();
                     });
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
          {"picture", HasPicture(now)},
          {"problem", ""}};
}

json PlainCard(const char* state, const std::string& problem) {
  return {{"state", state},  {"done", 0},        {"steps", 0},        {"poses", 0},
          {"kind", "poses"}, {"picture", false}, {"problem", problem}};
}

/// The first photograph of the template; of a performance the first frame of a film.
fs::path PictureOf(Snapshot& now, const fs::path& kept) {
  if (now.graph().kind == pipeline::ProjectKind::kPerformance) {
    for (const std::string& shot : now.graph().poses) {
      const auto cameras = FilmsIn(FilmFolder(now.project(), now.file(), shot));
      if (!cameras.empty())
        return FramePicture(kept, FilmOf(now, shot, cameras.front().name), 0, kCardWidth);
    }
    return {};
  }
  const fs::path photos = now.PhotoFolder(now.graph().template_pose);
  const auto names = OriginalPhotographs(photos);
  if (names.empty() || pipeline::RealDisk().LeadsOutside(photos / names.front(), photos)) return {};
  return PictureFile(kept, photos / names.front(), kCardWidth);
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
  fs::path picture;
  try {
    Snapshot now(folder);
    picture = PictureOf(now, folder / ".keypose/studio/pictures");
  } catch (const Error&) {
    // the card says what is wrong
  }
  if (picture.empty()) throw NotFound("there is no picture yet");
  return picture;
}

}  // namespace keypose::studio
