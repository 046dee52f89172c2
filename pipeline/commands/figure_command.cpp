#include "pipeline/commands/figure_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/movie_header.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/pictures/raw_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"
#include "pipeline/cache/project_lock.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/graph/figure_setting.h"
#include "pipeline/graph/pipeline_edit.h"
#include "pipeline/graph/sources.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

bool IsPerformance(const OpenedProject& opened) {
  return opened.graph().kind == ProjectKind::kPerformance;
}

/// Where the pose's photographs, or the shot's films, lie.
fs::path SourcesOf(const OpenedProject& opened, const std::string& pose) {
  const PoseRule& rule = *opened.file().FindPose(pose);
  return opened.project() / OnDisk(RealDisk(), opened.project(),
                                   IsPerformance(opened) ? VideoOf(rule) : PhotographsOf(rule));
}

/// The pose or shot that is meant.
std::string PoseMeant(const OpenedProject& opened, const FigureOptions& options) {
  const bool shots = IsPerformance(opened);
  const char* const kind = shots ? "shot" : "pose";
  const std::string &given = shots ? options.shot : options.pose,
                    &other = shots ? options.pose : options.shot;
  if (!other.empty())
    throw UsageError(fmt::format("this project has {0}s; say --{0} NAME, with one of {1}", kind,
                                 fmt::join(opened.graph().poses, ", ")));
  if (!given.empty()) return Composed(given);
  if (opened.graph().poses.size() == 1) return opened.graph().poses.front();
  throw UsageError(fmt::format("say which {0}: --{0} NAME, with one of {1}", kind,
                               fmt::join(opened.graph().poses, ", ")));
}

/// Checks what is typed against the photographs of a pose.
class Photographs {
 public:
  explicit Photographs(fs::path folder) : folder_(std::move(folder)) {
    files_ = RealDisk().FilesBelow(folder_);
    std::erase_if(files_, [](const std::string& file) { return !IsShotName(file); });
    // A RAW file counts where it has no other photograph beside it.
    std::erase_if(files_, [&](const std::string& file) {
      return IsRawName(file) && HasTwin(fs::path(file).replace_extension());
    });
    if (files_.empty())
      throw InputError(fmt::format("there are no photographs in {}", folder_.string()));
  }

  FigureStroke Checked(FigureStroke stroke) const {
    stroke.picture = PhotographMeant(files_, stroke.picture);
    const fs::path file = folder_ / stroke.picture;
    const ImageInfo info = IsRawName(file) ? ReadRawInfo(file) : ReadImageInfo(file);
    RequireWithin(stroke, {info.width, info.height});
    return stroke;
  }

 private:
  bool HasTwin(const fs::path& stem) const {
    return std::any_of(files_.begin(), files_.end(), [&](const std::string& file) {
      return !IsRawName(file) && fs::path(file).replace_extension() == stem;
    });
  }

  fs::path folder_;
  std::vector<std::string> files_;
};

/// Checks what is typed against the films of a shot.
class Films {
 public:
  explicit Films(const fs::path& folder) : films_(CameraFilms(folder)) {
    if (films_.empty()) throw InputError(fmt::format("there are no films in {}", folder.string()));
  }

  FigureStroke Checked(FigureStroke stroke) const {
    const auto place = FilmedPlaceOf(stroke);
    if (!place)
      throw UsageError(fmt::format(
          "'{}' names no frame of a film; write it as CAMERA/FRAME:X,Y, as in {}/0:512,300",
          stroke.picture, films_.front().name));
    const CameraFilm& film = FilmOf(*place);
    if (!film.video.empty() && !IsMovie(film.video)) {
      fmt::print("{} has no header that says its frames and size, so these are not checked\n",
                 PrintableName(film.video));
      return stroke;
    }
    RequireFrame(film, *place);
    RequireWithin(stroke, SizeOfFrame(film, place->frame));
    return stroke;
  }

 private:
  const CameraFilm& FilmOf(const FilmedPlace& place) const {
    std::vector<std::string> cameras;
    for (const CameraFilm& film : films_) {
      if (film.name == place.camera) return film;
      cameras.push_back(film.name);
    }
    throw UsageError(
        fmt::format("there is no camera '{}'{}", place.camera, Suggestion(place.camera, cameras)));
  }

  static void RequireFrame(const CameraFilm& film, const FilmedPlace& place) {
    const int frames =
        film.video.empty() ? SizeOf(film.pictures) : ReadMovieHeader(film.video).frames;
    if (place.frame >= frames)
      throw UsageError(
          fmt::format("there is no frame {} of camera '{}': its film has {}, counted from 0 to {}",
                      place.frame, film.name, frames, frames - 1));
  }

  static PictureSize SizeOfFrame(const CameraFilm& film, int frame) {
    if (film.video.empty()) {
      const ImageInfo info = ReadImageInfo(film.pictures[static_cast<std::size_t>(frame)]);
      return {info.width, info.height};
    }
    const MovieHeader header = ReadMovieHeader(film.video);
    return {header.width, header.height};
  }

  std::vector<CameraFilm> films_;
};

/// The strokes that the flags say, checked against the pictures that there are.
std::vector<FigureStroke> SaidNow(const OpenedProject& opened, const std::string& pose,
                                  const FigureOptions& options) {
  std::vector<FigureStroke> strokes;
  const auto add = [&](const std::vector<std::string>& texts, bool figure) {
    for (const std::string& text : texts) {
      strokes.push_back(ParseTypedStroke(text));
      strokes.back().figure = figure;
    }
  };
  add(options.at, true);
  add(options.not_at, false);
  if (strokes.empty()) return strokes;
  const fs::path folder = SourcesOf(opened, pose);
  const auto check = [&](const auto& pictures) {
    for (FigureStroke& stroke : strokes) stroke = pictures.Checked(std::move(stroke));
  };
  if (IsPerformance(opened))
    check(Films(folder));
  else
    check(Photographs(folder));
  return strokes;
}

/// @return whether pipeline.yaml was changed
bool Write(const fs::path& project, const FigureOptions& options) {
  const fs::path file = project / "pipeline.yaml";
  const std::string revision = RevisionOf(file), text = ReadFile(file);
  const OpenedProject opened(project, {});
  const std::string pose = PoseMeant(opened, options);
  const Step& step = FigureStep(opened.graph(), pose);
  const auto before = options.clear ? std::vector<FigureStroke>() : FigureStrokesOf(step);
  const auto strokes = WithStrokes(before, SaidNow(opened, pose, options));
  RequireNoContradiction(strokes);
  const std::string edited =
      WithFigure(ParsePipelineFile(text, "pipeline.yaml"), text, step, strokes);
  if (edited == text) return false;
  WritePipelineFile(project, edited, revision);
  return true;
}

/// Again when somebody else writes the file at the same time.
bool WriteInTurn(const fs::path& project, const FigureOptions& options) {
  constexpr int kTries = 20;
  for (int i = 0;; ++i) {
    try {
      return Write(project, options);
    } catch (const ChangedMeanwhile&) {
      if (i + 1 == kTries)
        throw DiskError(fmt::format("{} is changed all the time by another program; try again",
                                    (project / "pipeline.yaml").string()));
    }
  }
}

void PrintStrokes(const Step& step, bool shots) {
  const auto strokes = FigureStrokesOf(step);
  if (strokes.empty()) {
    fmt::print("nothing is said of what the figure of {} '{}' is\n", shots ? "shot" : "pose",
               step.pose);
    return;
  }
  fmt::print("{} '{}', for its step {}:\n", shots ? "shot" : "pose", step.pose, step.rule);
  for (FigureStroke stroke : strokes) {
    const char* const what = stroke.figure ? "the figure    " : "not the figure";
    stroke.figure = true;
    fmt::print("  {}  {}\n", what, FigureText(stroke));
  }
}

/// The picture that shows what was taken for the figure, below out/; empty if the step has none.
fs::path PictureOf(const Step& step) {
  for (const NamedResult& result : step.results)
    if (LowerExtension(result.path) == ".jpg") return result.path;
  return {};
}

void PrintNext(const OpenedProject& opened, const Step& step, const StepPlan& planned,
               const std::string& folder) {
  const int after = SizeOf(StepsThatFollow(opened.graph(), step));
  const std::string followers =
      after > 0 ? fmt::format(", and the {} that follow{} if its result changes", after,
                              after == 1 ? "s" : "")
                : "";
  if (planned.state == StepPlan::State::kDone)
    fmt::print("{} was made with this before, and is taken from the cache{}\n", step.id, followers);
  else if (planned.last)
    fmt::print("{} will run again{}\n", step.id, followers);
  else
    fmt::print("{} has not run yet, and will look at this\n", step.id);
  const std::string in = folder.empty() ? "" : " -C " + ShellWord(folder);
  const fs::path picture = PictureOf(step);
  if (picture.empty())
    fmt::print("next: keypose run{}\n", in);
  else
    fmt::print(
        "next: keypose run{} --until {}\n"
        "      look at {}, then keypose run{}\n",
        in, step.id, (fs::path("out") / picture).generic_string(), in);
}

}  // namespace

ExitCode FigureCommand(const FigureOptions& options) {
  const fs::path project = FindProject(options.folder);
  const bool changed = options.changes() && WriteInTurn(project, options);
  OpenedProject opened(project, {});
  const Step& step = FigureStep(opened.graph(), PoseMeant(opened, options));
  PrintStrokes(step, IsPerformance(opened));
  if (!options.changes()) return ExitCode::kOk;
  if (!changed) fmt::print("this was said already; pipeline.yaml stays as it is\n");
  const Plan plan(opened.graph(), opened.workshop(), {});
  opened.workshop().hasher.Save();
  const auto index = static_cast<int>(&step - opened.graph().steps.data());
  PrintNext(opened, step, plan[index], options.folder);
  if (const std::string holder = LockHolder(opened.state()); changed && !holder.empty())
    fmt::print("the project is in use by {}; what runs now does not see this yet\n", holder);
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
