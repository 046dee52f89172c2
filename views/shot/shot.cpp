#include "views/shot/shot.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/io/pictures/film_kind.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/project/frame_names.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"
#include "views/decode/film_decoder.h"
#include "views/shot/film_clocks.h"
#include "views/shot/sync_check.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

constexpr const char* kRateFile = "rate.json";
constexpr double kMostRate = 1e6;  // frames per second

FrameSource OpenVideo(const fs::path& path) {
  FrameSource source;
  source.video = path;
  source.index = std::make_shared<const FilmIndex>(ReadFilmIndex(path));
  source.frames = source.index->frames();
  source.frames_per_second = source.index->rate.per_second;
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

FrameSource OfPictures(const std::vector<fs::path>& pictures) {
  FrameSource source;
  source.pictures = pictures;
  source.frames = SizeOf(pictures);
  return source;
}

std::map<std::string, FrameSource> SourcesIn(const fs::path& folder) {
  std::map<std::string, FrameSource> sources;
  for (const CameraFilm& film : CameraFilms(folder))
    sources[film.name] = film.video.empty() ? OfPictures(film.pictures) : OpenVideo(film.video);
  return sources;
}

/// Words on what is there instead of films.
std::string WordsOnOthers(const fs::path& folder) {
  if (!fs::is_directory(folder)) return "";
  std::vector<fs::path> others;
  for (const fs::path& camera : NumberedContent(folder)) {
    if (fs::is_regular_file(camera)) others.push_back(camera);
    if (!fs::is_directory(camera) || camera.filename() == "background") continue;
    for (const fs::path& picture : NumberedContent(camera)) {
      if (const std::string kind = LowerExtension(picture); kind == ".exr" || kind == ".dpx")
        return "; " + PrintableName(picture.filename()) +
               " and its like are read by locate and composite only: make them TIFF or PNG with "
               "the colours as they should look (sRGB)";
      if (IsFilm(picture))
        return "; " + PrintableName(camera.filename() / picture.filename()) +
               " is a film in a folder of its own: move it into the shot's folder, named as its "
               "camera";
      if (fs::is_regular_file(picture)) others.push_back(picture);
    }
  }
  if (others.empty()) return "";
  const std::string cure = CureFor(others);
  return "; there are " + KindsOf(others) + (cure.empty() ? "" : "; " + cure);
}

fs::path PlateOf(const fs::path& folder, const std::string& camera) {
  if (fs::is_directory(folder))
    for (const fs::path& path : NumberedContent(folder))
      if (path.stem() == camera && IsFramePicture(path)) return path;
  return {};
}

/// On pictures whose names do not tell their order; empty: they do.
std::string WordsOnOrder(const ShotCamera& camera) {
  const std::vector<fs::path>& pictures = camera.pictures.pictures;
  std::vector<std::string> stems;
  for (const fs::path& picture : pictures) stems.push_back(picture.stem().string());
  const FrameNumbering numbering = NumberNames(stems);
  std::string fault = numbering.fault;
  for (std::size_t i = 1; fault.empty() && i < numbering.numbers.size(); ++i)
    if (numbering.numbers[i] == numbering.numbers[i - 1])
      fault = stems[i] + " has the frame number of " + stems[i - 1];
  if (fault.empty()) return "";
  return "camera " + camera.name + ": the picture " + WithoutOddBytes(fault) +
         "; the pictures are taken in the order of their names";
}

/// On pictures of kinds that are not read, beside those of a film; empty: there are none.
std::string WordsOnLeftOut(const ShotCamera& camera) {
  const std::vector<fs::path>& pictures = camera.pictures.pictures;
  if (pictures.empty()) return "";
  std::set<fs::path> stems;
  for (const fs::path& picture : pictures) stems.insert(picture.stem());
  std::vector<fs::path> others = NumberedContent(pictures.front().parent_path());
  std::erase_if(others, [&](const fs::path& file) {
    return stems.contains(file.stem()) || !fs::is_regular_file(file) || CureFor({file}).empty();
  });
  if (others.empty()) return "";
  return "camera " + camera.name + ": " + WithoutOddBytes(KindsOf(others)) +
         " are not read and left out; " + CureFor(others);
}

void RequireMaskForEach(const ShotCamera& camera) {
  if (camera.masks.empty() || camera.pictures.empty()) return;
  if (camera.masks.frames == camera.pictures.frames) return;
  throw InputError("camera " + camera.name + " has " + std::to_string(camera.pictures.frames) +
                   " frames but " + std::to_string(camera.masks.frames) +
                   " masks; a mask for each frame is needed");
}

FilmJoin JoinByClocks(std::vector<ShotCamera>& cameras, FilmGaps gaps, const ClockWish& wish,
                      const Progress* progress) {
  FilmClocks clocks;
  if (wish.how == ClockWish::How::kFound) clocks = FindFilmClocks(cameras, progress);
  if (wish.how == ClockWish::How::kGiven) clocks = GivenFilmClocks(cameras, wish);
  SetClocks(clocks.clocks, &cameras);
  FilmJoin join =
      JoinFilms(cameras, gaps, clocks.clocks.empty() ? FilmEnds::kEach : FilmEnds::kCommon);
  join.clocks = std::move(clocks.clocks);
  join.notes.insert(join.notes.begin(), clocks.notes.begin(), clocks.notes.end());
  return join;
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

Shot OpenShot(const fs::path& folder, FilmGaps gaps, const ClockWish& clocks,
              const Progress* progress) {
  Shot shot;
  std::map<std::string, FrameSource> pictures = SourcesIn(folder);
  std::map<std::string, FrameSource> masks = SourcesIn(folder / "masks");
  std::set<std::string> names;
  for (const auto& [name, source] : pictures) names.insert(name);
  if (pictures.empty())
    for (const auto& [name, source] : masks) names.insert(name);
  for (const std::string& name : names)
    shot.cameras.push_back(
        {name, pictures[name], masks[name], PlateOf(folder / "background", name)});
  std::sort(shot.cameras.begin(), shot.cameras.end(),
            [](const auto& a, const auto& b) { return NumberedBefore(a.name, b.name); });
  if (shot.cameras.empty())
    throw InputError(
        "the shot " + PrintableName(folder) +
        " has no camera; it needs a folder of numbered pictures, or a video, for each" +
        WordsOnOthers(folder));
  RequireSameGaps(shot.cameras);
  shot.join = JoinByClocks(shot.cameras, gaps, clocks, progress);
  shot.frames_per_second = shot.join.frames_per_second;
  if (!(shot.frames_per_second > 0)) shot.frames_per_second = RateIn(folder);
  for (const ShotCamera& camera : shot.cameras) {
    RequireMaskForEach(camera);
    for (const std::string& words :
         {WordsOnOrder(camera), WordsOnGaps(camera), WordsOnLeftOut(camera)})
      if (!words.empty()) shot.join.notes.push_back(words);
  }
  return shot;
}

std::vector<ShotCamera> OpenSeparateFilms(const fs::path& folder) {
  std::vector<ShotCamera> films;
  for (const auto& [name, source] : SourcesIn(folder)) films.push_back({name, source, {}, {}});
  std::sort(films.begin(), films.end(),
            [](const auto& a, const auto& b) { return NumberedBefore(a.name, b.name); });
  if (films.empty())
    throw InputError("the folder " + PrintableName(folder) +
                     " has no camera; it needs a folder of pictures, or a video, for each" +
                     WordsOnOthers(folder));
  return films;
}

void WriteShotRate(const fs::path& folder, double frames_per_second) {
  WriteFile(folder / kRateFile,
            nlohmann::json{{"schema", 1}, {"fps", frames_per_second}}.dump() + "\n");
}

std::vector<ShotCamera> OpenFilmsToShow(const fs::path& folder) {
  const std::vector<ShotCamera> separate = OpenSeparateFilms(folder);
  try {
    std::vector<ShotCamera> joined = separate;
    JoinFilms(joined);
    return joined;
  } catch (const InputError&) {
    return separate;  // the steps that read them say what is wrong
  }
}

struct FrameReader::Impl {
  FrameSource source;
  std::optional<FilmDecoder> film;
  fs::path first;  ///< the numbered picture that was read first; the others have its size
  int width = 0, height = 0;

  /// @throws InputError  another size than the first
  Image8 ReadPicture(const fs::path& path, int channels) {
    Image8 image = ReadImage(path, channels);
    if (first.empty()) {
      first = path;
      width = image.width;
      height = image.height;
    }
    if (image.width != width || image.height != height)
      throw InputError(fmt::format(
          "{} is {} x {} pixels, but {} beside it is {} x {}; the pictures of one film must have "
          "one size and one orientation: export them again, or take the odd ones out",
          path.string(), image.width, image.height, PrintableName(first), width, height));
    return image;
  }
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
  const int picture = source.order.empty() ? frame : source.order[static_cast<std::size_t>(frame)];
  if (source.video.empty()) return impl_->ReadPicture(source.pictures[picture], channels);
  if (!impl_->film)
    impl_->film.emplace(source.video, source.index ? source.index
                                                   : std::make_shared<const FilmIndex>(
                                                         ReadFilmIndex(source.video, progress)));
  return impl_->film->Read(picture, channels, progress);
}

}  // namespace keypose
