#include "pipeline/graph/shown_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

/// Empty where the film is no folder of numbered pictures; `locate` says what is wrong with it.
std::vector<FilmPicture> PicturesOf(const ShotRule& shot, const fs::path& project,
                                    const Disk& disk) {
  const fs::path film = project / OnDisk(disk, project, WithHome(shot.Given(kFilmWord)->text));
  const auto stat = disk.Stat(film);
  if (!stat || !stat->folder) return {};
  try {
    return NumberedPictures(film, disk.Children(film), FilmKinds::kPicturesOrLight);
  } catch (const InputError&) {
    return {};
  }
}

void RequireFilmAndFrames(const ShotRule& shot) {
  const auto fail = [&](const char* fault) {
    throw UsageError(fmt::format("{}: {}", shot.where.Text(), fault));
  };
  if (!shot.Given(kFilmWord))
    fail("the shot has no film; add the folder of its pictures, as in `film: film`");
  if (shot.shows.size() < 2)
    fail(
        "the shot says of fewer than two frames which pose they show; add them, as in "
        "`shows: {0: rest, 4: wave}`");
}

}  // namespace

void CheckShownFrames(const PipelineFile& file, const fs::path& project, const Disk& disk) {
  if (!file.shot) return;
  RequireFilmAndFrames(*file.shot);
  const std::vector<FilmPicture> pictures = PicturesOf(*file.shot, project, disk);
  if (pictures.empty()) return;
  for (const ShotRule::Shows& shown : file.shot->shows) {
    const bool there =
        std::any_of(pictures.begin(), pictures.end(),
                    [&](const FilmPicture& picture) { return picture.frame == shown.frame; });
    if (!there)
      throw UsageError(fmt::format(
          "{}: the film has no frame {}; frames count from its first picture, so {} is frame 0 and "
          "{} frame {}",
          shown.pose.where.Text(), shown.frame, PrintableName(pictures.front().path.filename()),
          PrintableName(pictures.back().path.filename()), pictures.back().frame));
  }
}

void CheckShownTimes(const PipelineFile& file) {
  if (!file.shot || file.timeline.empty() || !file.timeline.front().at_s) return;
  const double start = *file.timeline.front().at_s;
  const int first = file.shot->shows.front().frame;
  for (const ShotRule::Shows& shown : file.shot->shows) {
    const double seconds = (shown.frame - first) / file.shot->fps;
    const auto is_there = [&](const TimelineKey& key) {
      return key.pose.text == shown.pose.text &&
             std::round((*key.at_s - start) * file.fps) == std::round(seconds * file.fps);
    };
    if (std::any_of(file.timeline.begin(), file.timeline.end(), is_there)) continue;
    throw UsageError(fmt::format(
        "{}: the film shows '{}' in frame {}, {:.6g} s after the first shown frame, but the "
        "timeline has no key of it there; give it {{pose: {}, at: {:.6g}}}, or take the timeline "
        "out: then the film's frames are its keys",
        shown.pose.where.Text(), shown.pose.text, shown.frame, seconds, shown.pose.text,
        start + seconds));
  }
}

}  // namespace keypose::pipeline
