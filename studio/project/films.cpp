#include "studio/project/films.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/io/pictures/image_io.h"
#include "core/io/project/shot_io.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/graph/sources.h"
#include "studio/project/kept_picture.h"
#include "studio/project/pose_photographs.h"
#include "views/decode/film_index.h"
#include "views/shot/shot.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string StampOf(const fs::path& file) {
  const auto stat = pipeline::RealDisk().Stat(file);
  return fmt::format("{} {} {};", file.string(), stat ? stat->size : 0, stat ? stat->mtime_ns : 0);
}

/// Another text where the films may have changed.
std::string StampOf(const std::vector<CameraFilm>& films) {
  std::string stamp;
  for (const CameraFilm& film : films) {
    stamp += StampOf(film.video.empty() ? film.pictures.front() : film.video);
    stamp += std::to_string(film.pictures.size());
  }
  return stamp;
}

/// Links to other places are not followed, as nowhere in the studio.
std::vector<ShotCamera> WithoutLinks(std::vector<ShotCamera> cameras, const fs::path& folder) {
  const auto leads_out = [&](const fs::path& file) {
    return pipeline::RealDisk().LeadsOutside(file, folder);
  };
  std::erase_if(cameras, [&](const ShotCamera& camera) {
    const FrameSource& film = camera.pictures;
    return film.video.empty() ? std::any_of(film.pictures.begin(), film.pictures.end(), leads_out)
                              : leads_out(film.video);
  });
  return cameras;
}

/// The picture of a film that shows a frame; another one when other films lie beside it.
int PictureOf(const FrameSource& film, int frame) {
  return film.order.empty() ? frame : film.order[static_cast<std::size_t>(frame)];
}

/// All pictures in their order.
FrameSource Unjoined(FrameSource film) {
  film.order.clear();
  if (film.index) film.frames = film.index->frames();
  return film;
}

/// Films that were opened, and decoders that go on from the frame that was asked for last.
class Shelf {
 public:
  std::vector<ShotCamera> Cameras(const fs::path& folder) {
    const std::string stamp = StampOf(CameraFilms(folder));
    const std::lock_guard<std::mutex> lock(mutex_);
    Opened& opened = opened_[folder];
    if (opened.stamp != stamp || opened.cameras.empty())
      opened = {stamp, WithoutLinks(OpenFilmsToShow(folder), folder)};
    return opened.cameras;
  }

  Image8 Read(const FrameSource& film, int frame, int channels) {
    if (film.video.empty()) return FrameReader(film).Read(frame, channels);
    const std::lock_guard<std::mutex> lock(decoding_);
    if (readers_.size() >= kMostReaders) readers_.clear();
    const std::string stamp = StampOf(film.video);
    FrameReader& reader = readers_.try_emplace(stamp, Unjoined(film)).first->second;
    return reader.Read(PictureOf(film, frame), channels);
  }

 private:
  /// Decoders hold some frames of memory each.
  static constexpr std::size_t kMostReaders = 12;
  struct Opened {
    std::string stamp;
    std::vector<ShotCamera> cameras;
  };
  std::mutex mutex_, decoding_;
  std::map<fs::path, Opened> opened_;
  std::map<std::string, FrameReader> readers_;
};

Shelf& TheShelf() {
  static Shelf shelf;
  return shelf;
}

/// Where the masks of a shot's actor are: nothing where there are none.
std::optional<fs::path> ActorMasks(Snapshot& snapshot, const std::string& shot) {
  const fs::path given = FilmFolder(snapshot.project(), snapshot.file(), shot) / "masks";
  if (fs::is_directory(given)) return given;
  const auto made = snapshot.ResultPath("silhouettes", shot, "masked");
  if (made && fs::is_directory(*made / "masks")) return *made / "masks";
  return std::nullopt;
}

std::vector<ShotCamera> MasksIn(Snapshot& snapshot, const std::string& shot) {
  const auto folder = ActorMasks(snapshot, shot);
  try {
    return folder ? FilmsIn(*folder) : std::vector<ShotCamera>{};
  } catch (const Error&) {
    return {};  // the steps that read them say what is wrong
  }
}

const ShotCamera* Named(const std::vector<ShotCamera>& cameras, const std::string& name) {
  const auto found = std::find_if(cameras.begin(), cameras.end(),
                                  [&](const ShotCamera& camera) { return camera.name == name; });
  return found == cameras.end() ? nullptr : &*found;
}

/// The file by which a kept picture of a frame is known.
const fs::path& FileOf(const FrameSource& film, int frame) {
  if (frame < 0 || frame >= film.frames)
    throw NotFound(fmt::format("there is no frame {}: the film has {}", frame, film.frames));
  return film.video.empty() ? film.pictures[static_cast<std::size_t>(frame)] : film.video;
}

}  // namespace

fs::path FilmFolder(const fs::path& project, const pipeline::PipelineFile& file,
                    const std::string& shot) {
  const pipeline::PoseRule* rule = file.FindPose(shot);
  if (rule == nullptr || file.kind != pipeline::ProjectKind::kPerformance)
    throw UsageError(fmt::format("the project has no shot '{}'", shot));
  return project / pipeline::OnDisk(pipeline::RealDisk(), project, pipeline::VideoOf(*rule));
}

std::vector<ShotCamera> FilmsIn(const fs::path& folder) { return TheShelf().Cameras(folder); }

PictureSize FrameSize(const FrameSource& film, int frame) {
  const fs::path& file = FileOf(film, frame);
  if (film.video.empty()) {
    const ImageInfo info = ReadImageInfo(file);
    return {info.width, info.height};
  }
  if (film.index) return {film.index->width, film.index->height};
  const Image8 picture = TheShelf().Read(film, frame, 1);
  return {picture.width, picture.height};
}

json FilmsJson(Snapshot& snapshot, const std::string& shot) {
  const fs::path folder = FilmFolder(snapshot.project(), snapshot.file(), shot);
  json films = {{"problem", ""}, {"cameras", json::array()}};
  try {
    const std::vector<ShotCamera> masks = MasksIn(snapshot, shot);
    for (const ShotCamera& camera : FilmsIn(folder)) {
      const PictureSize size = FrameSize(camera.pictures, 0);
      const ShotCamera* mask = Named(masks, camera.name);
      films["cameras"].push_back(
          {{"name", camera.name},
           {"frames", camera.pictures.frames},
           {"width", size.width},
           {"height", size.height},
           {"masked", mask != nullptr && mask->pictures.frames == camera.pictures.frames}});
    }
  } catch (const Error& error) {
    films["problem"] = error.what();
  }
  return films;
}

FrameSource FilmOf(Snapshot& snapshot, const std::string& shot, const std::string& camera) {
  const auto cameras = FilmsIn(FilmFolder(snapshot.project(), snapshot.file(), shot));
  const ShotCamera* found = Named(cameras, camera);
  if (found == nullptr) throw NotFound(fmt::format("shot '{}' has no camera '{}'", shot, camera));
  return found->pictures;
}

FrameSource MasksOf(Snapshot& snapshot, const std::string& shot, const std::string& camera) {
  FilmFolder(snapshot.project(), snapshot.file(), shot);
  const auto cameras = MasksIn(snapshot, shot);
  const ShotCamera* found = Named(cameras, camera);
  if (found == nullptr)
    throw NotFound(fmt::format("camera '{}' of shot '{}' has no masks yet", camera, shot));
  return found->pictures;
}

fs::path FramePicture(const fs::path& folder, const FrameSource& film, int frame, int width) {
  const fs::path& file = FileOf(film, frame);
  if (film.video.empty()) return PictureFile(folder, file, width);
  return KeptPicture(folder, file, fmt::format("frame {} {}", PictureOf(film, frame), width),
                     ".jpg", [&](const fs::path& to) {
                       Image8 picture = TheShelf().Read(film, frame, 3);
                       if (width > 0 && width < picture.width)
                         picture = Resized(picture, width,
                                           std::max(1, picture.height * width / picture.width));
                       WriteImage(to, picture, width > 0 ? 82 : 92);
                     });
}

fs::path FrameMask(const fs::path& folder, const FrameSource& masks, int frame) {
  const fs::path& file = FileOf(masks, frame);
  if (masks.video.empty() && LowerExtension(file) == ".png") return file;
  return KeptPicture(folder, file, fmt::format("mask of frame {}", frame), ".png",
                     [&](const fs::path& to) { WriteImage(to, TheShelf().Read(masks, frame, 1)); });
}

CutFilm CutIntoPictures(const fs::path& project, const std::string& video) {
  const fs::path file = project / video;
  if (!StaysBelow(video) || !fs::is_regular_file(file) ||
      pipeline::RealDisk().LeadsOutside(file, project))
    throw UsageError(fmt::format("the project has no video {}", video));
  FrameSource film;
  film.video = file;
  film.index = std::make_shared<const FilmIndex>(ReadFilmIndex(file));
  film.frames = film.index->frames();
  if (film.frames < 2 || film.frames > kMostCutFrames)
    throw UsageError(fmt::format(
        "{} has {} pictures; a shot here has 2 to {}: cut it to the part that is needed first",
        video, film.frames, kMostCutFrames));
  const fs::path folder = fs::path(file).replace_extension("");
  const CutFilm cut = {folder.lexically_relative(project).generic_string(), film.frames,
                       film.index->rate.per_second};
  if (fs::exists(folder)) {
    if (fs::is_directory(folder) && static_cast<int>(FilmPictures(folder).size()) == film.frames)
      return cut;
    throw UsageError(fmt::format("{} is there already, and holds something else", cut.folder));
  }
  const fs::path writing = project / ".keypose/studio/cut";
  fs::remove_all(writing);
  fs::create_directories(writing);
  FrameReader reader(film);
  for (int frame = 0; frame < film.frames; ++frame)
    WriteImage(writing / fmt::format("{}_{:04}.png", folder.filename().string(), frame),
               reader.Read(frame, 3));
  fs::rename(writing, folder);
  return cut;
}

}  // namespace keypose::studio
