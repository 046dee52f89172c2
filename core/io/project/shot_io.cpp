#include "core/io/project/shot_io.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "core/io/pictures/film_kind.h"
#include "core/io/project/frame_names.h"
#include "core/io/project/lens_use.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr double kFarthest = 1e12;  // a coordinate beyond it is a damaged file

/// Reads fields of one object. Messages name `where`.
class ShotFields {
 public:
  ShotFields(const json& object, std::string where) : object_(object), where_(std::move(where)) {
    if (!object.is_object()) Fail("is not an object");
  }

  [[noreturn]] void Fail(const std::string& what) const { throw InputError(where_ + " " + what); }
  bool Has(const char* name) const { return object_.contains(name) && !object_[name].is_null(); }
  const json& Get(const char* name) const {
    if (!Has(name)) Fail(fmt::format("has no '{}'", name));
    return object_[name];
  }
  ShotFields Part(const char* name) const { return {Get(name), where_ + ": '" + name + "'"}; }

  double Number(const char* name, double least, double most) const {
    const json& value = Get(name);
    if (!value.is_number()) Fail(fmt::format("has a '{}' that is not a number", name));
    const double number = value.get<double>();
    if (!(number >= least && number <= most))
      Fail(fmt::format("has '{}' {:.6g}, which must lie in {:g} to {:g}", name, number, least,
                       most));
    return number;
  }
  int Whole(const char* name, int least, int most) const {
    if (!Get(name).is_number_integer())
      Fail(fmt::format("has a '{}' that is not a whole number", name));
    return static_cast<int>(Number(name, least, most));
  }
  std::string Text(const char* name) const {
    if (!Get(name).is_string()) Fail(fmt::format("has a '{}' that is not a text", name));
    return Get(name).get<std::string>();
  }
  std::string OneOf(const char* name, const std::vector<std::string>& words) const {
    const std::string word = Text(name);
    if (std::find(words.begin(), words.end(), word) == words.end())
      Fail(fmt::format("has '{}' \"{}\"; did you mean \"{}\"?", name, word,
                       NearestWord(word, words)));
    return word;
  }
  bool Truth(const char* name) const {
    if (!Get(name).is_boolean()) Fail(fmt::format("has a '{}' that is not true or false", name));
    return Get(name).get<bool>();
  }
  template <int N>
  Eigen::Matrix<double, N, 1> Vector(const char* name) const {
    const json& list = Get(name);
    if (!list.is_array() || list.size() != N)
      Fail(fmt::format("has a '{}' that is not a list of {} numbers", name, N));
    Eigen::Matrix<double, N, 1> vector;
    for (int i = 0; i < N; ++i) {
      const json& value = list[static_cast<std::size_t>(i)];
      if (!value.is_number() || !(std::abs(value.get<double>()) <= kFarthest))
        Fail(fmt::format("has a '{}' that is not a list of {} finite numbers", name, N));
      vector[i] = value.get<double>();
    }
    return vector;
  }
  Eigen::Quaterniond Rotation() const {
    const Eigen::Vector4d q = Vector<4>("rotation");
    if (std::abs(q.norm() - 1) > 1e-3)
      Fail(fmt::format("has a 'rotation' of length {:.6g}; a quaternion [w, x, y, z] has 1",
                       q.norm()));
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  }

 private:
  const json& object_;
  std::string where_;
};

Camera CameraFrom(const ShotFields& root, const ShotFields& lens, const std::string& where) {
  Camera camera;
  camera.width = root.Whole("width", 1, 1 << 20);
  camera.height = root.Whole("height", 1, 1 << 20);
  constexpr double kMost = 1e7;
  camera.fx = camera.fy = lens.Has("f") ? lens.Number("f", 0.01, kMost) : 0;
  if (lens.Has("fx") || !lens.Has("f")) camera.fx = lens.Number("fx", 0.01, kMost);
  if (lens.Has("fy") || !lens.Has("f")) camera.fy = lens.Number("fy", 0.01, kMost);
  camera.cx = lens.Number("cx", -kMost, kMost);
  camera.cy = lens.Number("cy", -kMost, kMost);
  const auto distortion = [&](const char* name) {
    return lens.Has(name) ? lens.Number(name, -kMost, kMost) : 0;
  };
  camera.k1 = distortion("k1");
  camera.k2 = distortion("k2");
  camera.p1 = distortion("p1");
  camera.p2 = distortion("p2");
  RequireUsableCamera(camera, where);
  return camera;
}

Rigid3 PlaceFrom(const ShotFields& fields) {
  return {fields.Rotation(), fields.Vector<3>("translation")};
}

ShotFrame FrameFrom(const ShotFields& fields) {
  ShotFrame frame;
  frame.frame = fields.Whole("frame", 0, 1 << 24);
  frame.picture = fields.Text("picture");
  if (frame.picture.empty() || frame.picture.find('/') != std::string::npos)
    fields.Fail("has a 'picture' that is not the name of a file in the film's folder");
  if (fields.Has("pose")) frame.pose = fields.Text("pose");
  frame.camera_from_world = PlaceFrom(fields.Part("camera_from_world"));
  const ShotFields place = fields.Part("world_from_character");
  frame.world_from_character = {place.Has("scale") ? place.Number("scale", 1e-9, kFarthest) : 1,
                                place.Rotation().toRotationMatrix(),
                                place.Vector<3>("translation")};
  frame.method = fields.OneOf("method", {"features", "outlines", "clicks", "given"});
  if (fields.Has("contour_px")) frame.contour_px = fields.Number("contour_px", 0, kFarthest);
  if (fields.Has("iou")) frame.iou = fields.Number("iou", 0, 1);
  if (fields.Has("inliers")) frame.inliers = fields.Whole("inliers", 0, 1 << 30);
  return frame;
}

bool SamePlace(const Rigid3& a, const Rigid3& b) {
  return std::abs(std::abs(a.rotation.dot(b.rotation)) - 1) < 1e-12 &&
         (a.translation - b.translation).norm() <= 1e-9 * (1 + a.translation.norm());
}

void RequireOneSequence(const FilmedShot& shot, const std::string& source) {
  if (shot.frames.empty()) throw InputError(source + " has no frames; locate one at least");
  for (std::size_t i = 1; i < shot.frames.size(); ++i) {
    if (shot.frames[i].frame <= shot.frames[i - 1].frame)
      throw InputError(fmt::format("{}: frame {} comes after frame {}; sort them, each once",
                                   source, shot.frames[i].frame, shot.frames[i - 1].frame));
    if (shot.still &&
        !SamePlace(shot.frames[i].camera_from_world, shot.frames[0].camera_from_world))
      throw InputError(
          fmt::format("{}: frame {} has another camera_from_world than frame {}, but "
                      "'still' is true; make it false if the camera moves",
                      source, shot.frames[i].frame, shot.frames[0].frame));
  }
}

CameraBetween BetweenFrom(const ShotFields& fields) {
  return {fields.Number("frame", 0, 1 << 24), PlaceFrom(fields.Part("camera_from_world"))};
}

void RequireBetween(const FilmedShot& shot, const std::string& source) {
  if (shot.still && !shot.between.empty())
    throw InputError(source + " has cameras 'between' frames, but 'still' is true");
  for (std::size_t i = 0; i < shot.between.size(); ++i) {
    const double time = shot.between[i].frame;
    if (i > 0 && !(time > shot.between[i - 1].frame))
      throw InputError(fmt::format("{}: between[{}] at {:g} comes after {:g}; sort them, each once",
                                   source, i, time, shot.between[i - 1].frame));
    if (!(time > shot.frames.front().frame && time < shot.frames.back().frame))
      throw InputError(
          fmt::format("{}: between[{}] at {:g} is not between the first and the last "
                      "frame",
                      source, i, time));
    for (const ShotFrame& frame : shot.frames)
      if (frame.frame == time)
        throw InputError(
            fmt::format("{}: between[{}] is at frame {}, which has a camera of its own", source, i,
                        frame.frame));
  }
}

ordered_json ListOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
ordered_json ListOf(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

ordered_json JsonOf(const Rigid3& place) {
  return {{"rotation", ListOf(place.rotation)}, {"translation", ListOf(place.translation)}};
}

ordered_json JsonOf(const ShotFrame& frame) {
  ordered_json node = {{"frame", frame.frame},
                       {"picture", frame.picture},
                       {"pose", frame.pose.empty() ? ordered_json() : ordered_json(frame.pose)}};
  node["camera_from_world"] = JsonOf(frame.camera_from_world);
  const Similarity3& place = frame.world_from_character;
  node["world_from_character"] = {
      {"rotation", ListOf(Eigen::Quaterniond(place.rotation).normalized())},
      {"translation", ListOf(place.translation)},
      {"scale", place.scale}};
  node["method"] = frame.method;
  if (frame.contour_px) node["contour_px"] = *frame.contour_px;
  if (frame.iou) node["iou"] = *frame.iou;
  if (frame.inliers) node["inliers"] = *frame.inliers;
  return node;
}

bool IsPicture(const fs::path& path) {
  static const std::set<std::string> kinds{".png",  ".jpg",  ".jpeg", ".jfif", ".tif",
                                           ".tiff", ".heic", ".heif", ".hif"};
  return kinds.count(LowerExtension(path)) && path.filename().string().front() != '.';
}

bool IsLight(const fs::path& path) {
  static const std::set<std::string> kinds{".exr", ".dpx"};
  return kinds.count(LowerExtension(path)) && path.filename().string().front() != '.';
}

/// In the order of the frames.
std::vector<std::pair<long, fs::path>> Numbered(const fs::path& folder,
                                                const std::vector<std::string>& names) {
  std::vector<std::string> stems;
  for (const std::string& name : names) stems.push_back(fs::path(name).stem().string());
  const FrameNumbering numbering = NumberNames(stems);
  if (!numbering.fault.empty())
    throw InputError(PrintableName(folder) + ": the picture " + WithoutOddBytes(numbering.fault));
  std::vector<std::pair<long, fs::path>> numbered;
  for (std::size_t i = 0; i < names.size(); ++i)
    numbered.emplace_back(numbering.numbers[i], folder / names[i]);
  std::sort(numbered.begin(), numbered.end());
  for (std::size_t i = 1; i < numbered.size(); ++i)
    if (numbered[i].first == numbered[i - 1].first)
      throw InputError(
          fmt::format("{}: {} and {} have the same frame number {}; rename them, or remove one",
                      PrintableName(folder), PrintableName(numbered[i - 1].second.filename()),
                      PrintableName(numbered[i].second.filename()), numbered[i].first));
  return numbered;
}

/// Words on pictures of kinds that are not read, such as come from a compositing program.
std::string OtherPictures(const std::vector<std::string>& names) {
  for (const char* kind : {".exr", ".dpx", ".cin", ".tga", ".webp", ".bmp", ".gif", ".avif",
                           ".jp2", ".jxl", ".psd", ".ppm", ".pgm",  ".pnm", ".sgi", ".jpe",
                           ".cr2", ".cr3", ".nef", ".arw", ".dng",  ".raf", ".orf", ".rw2"}) {
    const auto count = std::count_if(names.begin(), names.end(), [&](const std::string& name) {
      return LowerExtension(name) == kind;
    });
    if (count == 0) continue;
    const std::string how =
        kind == std::string(".exr")
            ? ", such as by: oiiotool --frames 1001-1024 film.#.exr --colorconvert linear sRGB -d "
              "uint16 -o film.#.tif"
            : "";
    return fmt::format(
        ", but {} {} files; make them TIFF or PNG of 16 bits with the colours as they should look "
        "(sRGB){}",
        count, kind, how);
  }
  return "";
}

/// What cannot be numbered stays in its order.
void SortByFrame(std::vector<fs::path>* pictures) {
  std::vector<std::string> stems;
  for (const fs::path& picture : *pictures) stems.push_back(picture.stem().string());
  const FrameNumbering numbering = NumberNames(stems);
  if (!numbering.fault.empty()) return;
  std::vector<std::size_t> order(pictures->size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return numbering.numbers[a] < numbering.numbers[b];
  });
  std::vector<fs::path> sorted;
  for (const std::size_t i : order) sorted.push_back((*pictures)[i]);
  *pictures = std::move(sorted);
}

}  // namespace

long FrameNumberIn(const std::string& stem) {
  const std::size_t last = stem.find_last_of("0123456789");
  if (last == std::string::npos) return -1;
  std::size_t first = last;
  while (first > 0 && std::isdigit(static_cast<unsigned char>(stem[first - 1]))) --first;
  if (last - first >= 9) return -1;
  return std::stol(stem.substr(first, last - first + 1));
}

FilmedShot ParseShot(const std::string& text, const std::string& source) {
  RequireShallowJson(text, source);
  try {
    const json root_node = json::parse(text);
    const ShotFields root(root_node, source);
    if (const int schema = root.Whole("schema", 1, 1 << 20); schema != 1)
      root.Fail(fmt::format("has schema {}; this program reads schema 1", schema));
    FilmedShot shot;
    const ShotFields lens = root.Part("camera");
    if (lens.Has("model")) lens.OneOf("model", {"OPENCV"});
    shot.camera = CameraFrom(root, lens, source);
    if (lens.Has("focal")) shot.focal = lens.OneOf("focal", {"exif", "solved", "given", "kept"});
    if (lens.Has("focal_uncertainty"))
      shot.focal_uncertainty = lens.Number("focal_uncertainty", 0, 1e6);
    shot.fps = root.Number("fps", 0.01, 1000);
    shot.still = root.Truth("still");
    const json& frames = root.Get("frames");
    if (!frames.is_array()) root.Fail("has 'frames' that are not a list");
    for (std::size_t i = 0; i < frames.size(); ++i)
      shot.frames.push_back(FrameFrom({frames[i], fmt::format("{}: frames[{}]", source, i)}));
    RequireOneSequence(shot, source);
    if (root.Has("between")) {
      const json& between = root.Get("between");
      if (!between.is_array()) root.Fail("has 'between' that is not a list");
      for (std::size_t i = 0; i < between.size(); ++i)
        shot.between.push_back(
            BetweenFrom({between[i], fmt::format("{}: between[{}]", source, i)}));
      RequireBetween(shot, source);
    }
    return shot;
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{} is not a shot: {}", source, JsonFault(error)));
  }
}

FilmedShot ReadShot(const fs::path& path) { return ParseShot(ReadFile(path), PrintableName(path)); }

std::string ShotText(const FilmedShot& shot) {
  const Camera& c = shot.camera;
  ordered_json root = {{"schema", 1}, {"width", c.width}, {"height", c.height}, {"fps", shot.fps}};
  root["camera"] = {{"model", "OPENCV"},
                    {"fx", c.fx},
                    {"fy", c.fy},
                    {"cx", c.cx},
                    {"cy", c.cy},
                    {"k1", c.k1},
                    {"k2", c.k2},
                    {"p1", c.p1},
                    {"p2", c.p2},
                    {"focal", shot.focal},
                    {"focal_uncertainty", shot.focal_uncertainty}};
  root["still"] = shot.still;
  root["frames"] = ordered_json::array();
  for (const ShotFrame& frame : shot.frames) root["frames"].push_back(JsonOf(frame));
  for (const CameraBetween& camera : shot.between)
    root["between"].push_back(
        {{"frame", camera.frame}, {"camera_from_world", JsonOf(camera.camera_from_world)}});
  return root.dump(1) + "\n";
}

std::vector<FilmPicture> NumberedPictures(const fs::path& folder,
                                          const std::vector<std::string>& names, FilmKinds kinds) {
  std::vector<std::string> chosen;
  for (const std::string& name : names)
    if (IsPicture(folder / name)) chosen.push_back(name);
  if (chosen.empty() && kinds == FilmKinds::kPicturesOrLight)
    for (const std::string& name : names)
      if (IsLight(folder / name)) chosen.push_back(name);
  std::vector<FilmPicture> pictures;
  const auto numbered = Numbered(folder, chosen);
  for (const auto& [number, picture] : numbered)
    pictures.push_back(
        {static_cast<int>(number - numbered.front().first), picture, static_cast<int>(number)});
  return pictures;
}

std::vector<FilmPicture> FilmPictures(const fs::path& path, FilmKinds kinds) {
  if (fs::is_regular_file(path)) return {{0, path, 0}};
  if (!fs::is_directory(path))
    throw InputError(PrintableName(path) + " is neither a folder of pictures nor a picture");
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (entry.is_regular_file()) names.push_back(entry.path().filename().string());
  std::vector<FilmPicture> pictures = NumberedPictures(path, names, kinds);
  if (pictures.empty())
    throw InputError(
        PrintableName(path) + " has no pictures (0000.png, 0001.png, ...; JPEG, PNG, TIFF or HEIC" +
        (kinds == FilmKinds::kPicturesOrLight ? ", OpenEXR or DPX)" : ")") + OtherPictures(names));
  return pictures;
}

std::vector<fs::path> NumberedContent(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (!entry.path().filename().string().starts_with(".")) paths.push_back(entry.path());
  if (error)
    throw DiskError("cannot read the folder " + PrintableName(folder) + ": " + error.message());
  std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) {
    return NumberedBefore(a.filename().string(), b.filename().string());
  });
  return paths;
}

bool IsFramePicture(const fs::path& path) {
  static const std::set<std::string> kinds{".jpg", ".jpeg", ".png", ".tif", ".tiff"};
  return kinds.contains(LowerExtension(path));
}

std::vector<long> FrameNumbersOf(const std::vector<fs::path>& pictures) {
  std::vector<std::string> stems;
  for (const fs::path& picture : pictures) stems.push_back(picture.stem().string());
  const FrameNumbering numbering = NumberNames(stems);
  return numbering.counted ? numbering.numbers : std::vector<long>();
}

std::vector<CameraFilm> CameraFilms(const fs::path& folder) {
  std::vector<CameraFilm> films;
  if (!fs::is_directory(folder)) return films;
  for (const fs::path& path : NumberedContent(folder)) {
    CameraFilm film{path.filename().string(), {}, {}};
    if (film.name == "masks" || film.name == "background") continue;
    if (fs::is_directory(path)) {
      film.pictures = NumberedContent(path);
      std::erase_if(film.pictures, [](const fs::path& file) { return !IsFramePicture(file); });
      SortByFrame(&film.pictures);
    } else if (IsFilm(path)) {
      film.name = path.stem().string();
      film.video = path;
    }
    if (film.pictures.empty() && film.video.empty()) continue;
    if (std::any_of(films.begin(), films.end(),
                    [&](const CameraFilm& other) { return other.name == film.name; }))
      throw InputError("the shot " + PrintableName(folder) + " has two sources for the camera " +
                       film.name + "; leave a folder or a video");
    films.push_back(std::move(film));
  }
  std::sort(films.begin(), films.end(), [](const CameraFilm& a, const CameraFilm& b) {
    return NumberedBefore(a.name, b.name);
  });
  return films;
}

}  // namespace keypose
