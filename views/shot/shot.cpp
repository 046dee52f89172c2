#include "views/shot/shot.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <set>
#include <system_error>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/movie_header.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/shot/sync_check.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

constexpr const char* kRateFile = "rate.json";
constexpr double kMostRate = 1e6;  // frames per second

FrameSource OpenVideo(const fs::path& path) {
  cv::VideoCapture video(path.string());
  FrameSource source;
  source.video = path;
  if (video.isOpened()) {
    // A stream without an index says a hugely negative number, which no int can hold.
    source.frames = static_cast<int>(std::clamp(video.get(cv::CAP_PROP_FRAME_COUNT), 0.0, 1e9));
    source.frames_per_second = std::max(0.0, video.get(cv::CAP_PROP_FPS));
  }
  if (IsMovie(path)) try {  // a trimmed film has more pictures than the decoder gives
      source.frames = std::min(source.frames, ReadMovieHeader(path).frames);
    } catch (const InputError&) {
      // What can be decoded although its index is odd is a film.
    }
  if (source.frames < 1)
    throw InputError("the video " + PrintableName(path) +
                     " cannot be decoded; convert it to H.264 in an .mp4, or to numbered pictures");
  return source;
}

/// As WriteShotRate has left it; 0: nowhere.
double RateIn(const fs::path& folder) {
  const fs::path file = folder / kRateFile;
  if (!fs::is_regular_file(file)) return 0;
  const auto told = nlohmann::json::parse(ReadFile(file), nullptr, false);
  const bool fine = told.is_object() && told.contains("fps") && told["fps"].is_number();
  const double rate = fine ? told["fps"].get<double>() : 0;
  if (!(rate > 0 && rate < kMostRate))
    throw InputError(PrintableName(file) +
                     " has no rate `fps` above 0; make the masks anew with keypose silhouettes, or "
                     "delete it");
  return rate;
}

std::map<std::string, FrameSource> SourcesIn(const fs::path& folder) {
  std::map<std::string, FrameSource> sources;
  for (const CameraFilm& film : CameraFilms(folder))
    sources[film.name] = film.video.empty() ? FrameSource{film.pictures, {}, SizeOf(film.pictures)}
                                            : OpenVideo(film.video);
  return sources;
}

fs::path PlateOf(const fs::path& folder, const std::string& camera) {
  if (fs::is_directory(folder))
    for (const fs::path& path : NumberedContent(folder))
      if (path.stem() == camera && IsFramePicture(path)) return path;
  return {};
}

Image8 ToImage(const cv::Mat& bgr, int channels) {
  cv::Mat converted;
  cv::cvtColor(bgr, converted, channels == 1 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGR2RGB);
  Image8 image(converted.cols, converted.rows, channels);
  const std::size_t row = static_cast<std::size_t>(image.width) * channels;
  for (int y = 0; y < image.height; ++y)
    std::copy_n(converted.ptr<std::uint8_t>(y), row, image.at(0, y));
  return image;
}

}  // namespace

bool Shot::has_masks() const {
  return std::all_of(cameras.begin(), cameras.end(),
                     [](const ShotCamera& camera) { return !camera.masks.empty(); });
}

std::vector<std::string> Shot::names() const {
  std::vector<std::string> all;
  for (const ShotCamera& camera : cameras) all.push_back(camera.name);
  return all;
}

Shot OpenShot(const fs::path& folder) {
  Shot shot;
  std::map<std::string, FrameSource> pictures = SourcesIn(folder);
  std::map<std::string, FrameSource> masks = SourcesIn(folder / "masks");
  for (const auto& [name, source] : pictures)
    shot.frames_per_second = std::max(shot.frames_per_second, source.frames_per_second);
  if (!(shot.frames_per_second > 0)) shot.frames_per_second = RateIn(folder);
  std::set<std::string> names;
  for (const auto& [name, source] : pictures) names.insert(name);
  if (pictures.empty())
    for (const auto& [name, source] : masks) names.insert(name);
  for (const std::string& name : names) {
    ShotCamera camera{name, pictures[name], masks[name], PlateOf(folder / "background", name)};
    if (!camera.masks.empty() && !camera.pictures.empty() &&
        camera.masks.frames != camera.pictures.frames)
      throw InputError("camera " + name + " has " + std::to_string(camera.pictures.frames) +
                       " frames but " + std::to_string(camera.masks.frames) +
                       " masks; a mask for each frame is needed");
    shot.cameras.push_back(std::move(camera));
  }
  std::sort(shot.cameras.begin(), shot.cameras.end(),
            [](const auto& a, const auto& b) { return NumberedBefore(a.name, b.name); });
  if (shot.cameras.empty())
    throw InputError(
        "the shot " + PrintableName(folder) +
        " has no camera; it needs a folder of numbered pictures, or a video, for each");
  RequireSynchronised(shot.cameras);
  return shot;
}

std::vector<ShotCamera> OpenSeparateFilms(const fs::path& folder) {
  std::vector<ShotCamera> films;
  for (const auto& [name, source] : SourcesIn(folder)) films.push_back({name, source, {}, {}});
  std::sort(films.begin(), films.end(),
            [](const auto& a, const auto& b) { return NumberedBefore(a.name, b.name); });
  if (films.empty())
    throw InputError("the folder " + PrintableName(folder) +
                     " has no camera; it needs a folder of pictures, or a video, for each");
  return films;
}

void WriteShotRate(const fs::path& folder, double frames_per_second) {
  WriteFile(folder / kRateFile,
            nlohmann::json{{"schema", 1}, {"fps", frames_per_second}}.dump() + "\n");
}

struct FrameReader::Impl {
  FrameSource source;
  cv::VideoCapture video;
  int next = 0;
};

FrameReader::FrameReader(FrameSource source) : impl_(std::make_unique<Impl>()) {
  impl_->source = std::move(source);
}
FrameReader::~FrameReader() = default;
FrameReader::FrameReader(FrameReader&&) noexcept = default;
FrameReader& FrameReader::operator=(FrameReader&&) noexcept = default;

Image8 FrameReader::Read(int frame, int channels, const Progress* progress) {
  const FrameSource& source = impl_->source;
  if (frame < 0 || frame >= source.frames)
    throw UsageError("frame " + std::to_string(frame) + " was asked for, but there are " +
                     std::to_string(source.frames));
  if (source.video.empty()) return ReadImage(source.pictures[frame], channels);
  if (!impl_->video.isOpened() || frame < impl_->next) {
    impl_->video.open(source.video.string());
    impl_->next = 0;
  }
  cv::Mat picture;
  for (; impl_->next <= frame; ++impl_->next) {
    if (progress && progress->cancelled()) throw Cancelled();
    const bool last = impl_->next == frame;
    if (last ? !impl_->video.read(picture) : !impl_->video.grab())
      throw InputError("frame " + std::to_string(impl_->next) + " of " +
                       PrintableName(source.video) + " cannot be decoded; the video is damaged");
  }
  return ToImage(picture, channels);
}

}  // namespace keypose
