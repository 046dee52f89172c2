#include "core/io/project/colmap_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>

#include "core/io/pictures/image_kind.h"
#include "core/io/project/colmap_lens.h"
#include "core/io/project/lens_use.h"
#include "core/io/text/files.h"
#include "core/io/text/text_file.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

Lens SizedLens(Lens lens, std::uint64_t width, std::uint64_t height) {
  lens.width = static_cast<int>(std::min(width, std::uint64_t{kMostPixels}));
  lens.height = static_cast<int>(std::min(height, std::uint64_t{kMostPixels}));
  return lens;
}

std::string KnownModels() {
  std::string names;
  for (const ColmapLensModel& model : ColmapLensModels())
    names += (names.empty() ? "" : ", ") + model.name;
  return names;
}

class BinaryReader {
 public:
  explicit BinaryReader(const fs::path& path) : path_(path), bytes_(ReadFile(path)) {}
  template <class T>
  T Get() {
    if (at_ + sizeof(T) > bytes_.size())
      throw InputError(path_.string() + " is truncated at byte " + std::to_string(at_) +
                       "; run sfm again");
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string GetString() {
    std::string text;
    for (char c = Get<char>(); c != 0; c = Get<char>()) text += c;
    return text;
  }
  void Skip(std::uint64_t bytes) {
    if (bytes > bytes_.size() - at_)
      throw InputError(path_.string() + " is truncated; run sfm again");
    at_ += bytes;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  std::string bytes_;
  std::size_t at_ = 0;
};

using Cameras = std::map<std::uint32_t, Lens>;
struct NamedView {
  std::uint32_t id = 0, camera = 0;
  LensView view;
};

Cameras ReadCamerasBinary(const fs::path& path) {
  BinaryReader in(path);
  Cameras cameras;
  const auto count = in.Get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = in.Get<std::uint32_t>();
    const std::string where = path.string() + ": camera " + std::to_string(id);
    const auto number = in.Get<std::int32_t>();
    const std::optional<ColmapLensModel> model = FindColmapModel(number);
    if (!model)
      throw InputError(where +
                       " has a lens model that is newer than COLMAP 4.2 (binary files hold "
                       "its number alone, " +
                       std::to_string(number) +
                       "); write the model as text, which has names: `colmap model_converter "
                       "--output_type TXT`");
    const auto width = in.Get<std::uint64_t>(), height = in.Get<std::uint64_t>();
    std::vector<double> parameters(static_cast<std::size_t>(model->parameters));
    for (double& p : parameters) p = in.Get<double>();
    cameras[id] = SizedLens(ColmapLens(*model, parameters, where), width, height);
    RequireUsableLens(cameras[id], where);
  }
  return cameras;
}

Rigid3 PoseFrom(const std::array<double, 7>& q, const std::string& where) {
  constexpr double kLeastNorm = 1e-6;  // of the quaternion; it is 1 except for rounding
  for (const double number : q)
    if (!(std::abs(number) <= kMostCoordinate))
      throw InputError(
          where +
          " has a pose that is not finite or beyond 1e12; the file is damaged: run sfm again");
  if (!(Eigen::Vector4d(q[0], q[1], q[2], q[3]).norm() > kLeastNorm))
    throw InputError(where +
                     " has no rotation (its quaternion is 0); the file is damaged: run sfm again");
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(),
          Eigen::Vector3d(q[4], q[5], q[6])};
}

const Lens& CameraOf(const Cameras& cameras, std::uint32_t id, const fs::path& path) {
  const auto it = cameras.find(id);
  if (it == cameras.end())
    throw InputError(path.string() + " names camera " + std::to_string(id) +
                     ", which the cameras file does not have");
  return it->second;
}

std::vector<NamedView> ReadImagesBinary(const fs::path& path, const Cameras& cameras) {
  BinaryReader in(path);
  std::vector<NamedView> views;
  const auto count = in.Get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    NamedView named;
    named.id = in.Get<std::uint32_t>();
    std::array<double, 7> pose{};
    for (double& p : pose) p = in.Get<double>();
    named.view.camera_from_world =
        PoseFrom(pose, path.string() + ": image " + std::to_string(named.id));
    named.camera = in.Get<std::uint32_t>();
    named.view.lens = CameraOf(cameras, named.camera, path);
    named.view.name = in.GetString();
    const auto features = in.Get<std::uint64_t>();
    if (features > (std::uint64_t{1} << 32))
      throw InputError(path.string() + " is damaged; run sfm again");
    in.Skip(features * 24);
    views.push_back(std::move(named));
  }
  return views;
}

void RequireUsablePoint(const SparsePoint& point, const fs::path& path, std::uint64_t number) {
  if (!point.position.allFinite() || point.position.cwiseAbs().maxCoeff() > kMostCoordinate)
    throw InputError(path.string() + ": point " + std::to_string(number) +
                     " is not finite or beyond 1e12; the file is damaged: run sfm again");
}

struct RawPoint {
  SparsePoint point;
  std::vector<std::uint32_t> image_ids;
};

std::vector<RawPoint> ReadPointsBinary(const fs::path& path) {
  BinaryReader in(path);
  std::vector<RawPoint> points;
  const auto count = in.Get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    RawPoint raw;
    in.Get<std::uint64_t>();
    for (int k = 0; k < 3; ++k) raw.point.position(k) = in.Get<double>();
    for (int k = 0; k < 3; ++k) raw.point.color(k) = in.Get<std::uint8_t>();
    raw.point.error_px = in.Get<double>();
    RequireUsablePoint(raw.point, path, i);
    const auto track = in.Get<std::uint64_t>();
    for (std::uint64_t t = 0; t < track; ++t) {
      raw.image_ids.push_back(in.Get<std::uint32_t>());
      in.Get<std::uint32_t>();
    }
    points.push_back(std::move(raw));
  }
  return points;
}

std::string Trimmed(const std::string& line) {
  const char* const spaces = " \t\r\n";
  const std::size_t begin = line.find_first_not_of(spaces);
  if (begin == std::string::npos) return "";
  return line.substr(begin, line.find_last_not_of(spaces) + 1 - begin);
}

bool IsData(const std::string& line) { return !line.empty() && line[0] != '#'; }

/// All lines, without spaces at their ends.
std::vector<std::string> TrimmedLines(const fs::path& path) {
  std::istringstream in(ReadTextFile(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(Trimmed(line));
  return lines;
}

/// Lines that are neither empty nor comments.
std::vector<std::string> DataLines(const fs::path& path) {
  std::vector<std::string> lines = TrimmedLines(path);
  std::erase_if(lines, [](const std::string& line) { return !IsData(line); });
  return lines;
}

[[noreturn]] void ThrowLine(const fs::path& path, const std::string& line) {
  throw InputError(path.string() + ": cannot read the line '" + line.substr(0, 80) + "'");
}

Cameras ReadCamerasText(const fs::path& path) {
  Cameras cameras;
  for (const std::string& line : DataLines(path)) {
    std::istringstream in(line);
    std::uint32_t id = 0;
    std::string name;
    std::uint64_t width = 0, height = 0;
    if (!(in >> id >> name >> width >> height)) ThrowLine(path, line);
    const std::string where = path.string() + ": camera " + std::to_string(id);
    const std::optional<ColmapLensModel> model = FindColmapModel(name);
    if (!model)
      throw InputError(where + ": the lens model " + name + " is not known; known are " +
                       KnownModels() +
                       ". Write pictures and cameras of a pinhole: `colmap "
                       "image_undistorter`");
    std::vector<double> parameters;
    for (double p = 0; in >> p;) parameters.push_back(p);
    if (!in.eof()) ThrowLine(path, line);
    cameras[id] = SizedLens(ColmapLens(*model, parameters, where), width, height);
    RequireUsableLens(cameras[id], where);
  }
  return cameras;
}

/// A line of an image: ten words, of which the last, the name, may hold spaces.
std::optional<NamedView> ParseImage(const std::string& line, std::array<double, 7>* pose) {
  std::istringstream in(line);
  NamedView named;
  in >> named.id;
  for (double& p : *pose) in >> p;
  if (!(in >> named.camera >> std::ws) || !std::getline(in, named.view.name)) return std::nullopt;
  return named;
}

/// Whether a line holds features: words, three for each, none of them a name. Some programs leave
/// the line out, and the next one is an image.
bool IsFeatures(const std::string& line) {
  std::size_t words = 0;
  bool in_word = false;
  for (const char c : line) {
    const bool space = c == ' ' || c == '\t';
    words += !space && !in_word;
    in_word = !space;
  }
  if (words % 3 != 0) return false;
  std::istringstream in(line.substr(0, 400));  // an image has its name in the tenth word
  double number = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(words, 9); ++i)
    if (!(in >> number)) return false;
  std::string tenth;
  if (!(in >> tenth)) return true;
  char* end = nullptr;
  std::strtod(tenth.c_str(), &end);
  return *end == 0;
}

std::vector<NamedView> ReadImagesText(const fs::path& path, const Cameras& cameras) {
  std::vector<NamedView> views;
  const std::vector<std::string> lines = TrimmedLines(path);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!IsData(lines[i])) continue;
    std::array<double, 7> pose{};
    std::optional<NamedView> named = ParseImage(lines[i], &pose);
    if (!named) ThrowLine(path, lines[i]);
    named->view.camera_from_world =
        PoseFrom(pose, path.string() + ": image " + std::to_string(named->id));
    named->view.lens = CameraOf(cameras, named->camera, path);
    views.push_back(std::move(*named));
    if (i + 1 < lines.size() && IsFeatures(lines[i + 1])) ++i;
  }
  return views;
}

std::vector<RawPoint> ReadPointsText(const fs::path& path) {
  std::vector<RawPoint> points;
  for (const std::string& line : DataLines(path)) {
    std::istringstream in(line);
    RawPoint raw;
    std::uint64_t id = 0;
    int r = 0, g = 0, b = 0;
    Eigen::Vector3d& x = raw.point.position;
    if (!(in >> id >> x(0) >> x(1) >> x(2) >> r >> g >> b >> raw.point.error_px))
      ThrowLine(path, line);
    RequireUsablePoint(raw.point, path, id);
    raw.point.color << static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
        static_cast<std::uint8_t>(b);
    for (std::uint32_t image = 0, feature = 0; in >> image >> feature;)
      raw.image_ids.push_back(image);
    points.push_back(std::move(raw));
  }
  return points;
}

bool IsModel(const fs::path& folder) {
  return fs::exists(folder / "images.bin") || fs::exists(folder / "images.txt");
}

/// The folder itself, or the one model that COLMAP's and others' programs put below it.
fs::path ModelFolder(const fs::path& folder) {
  if (IsModel(folder)) return folder;
  std::vector<fs::path> below;
  for (const fs::path& parent : {folder / "sparse", folder}) {
    if (IsModel(parent)) below.push_back(parent);
    for (int number = 0; number < 10; ++number)
      if (const fs::path model = parent / std::to_string(number); IsModel(model))
        below.push_back(model);
    if (!below.empty()) break;
  }
  if (below.size() > 1)
    throw InputError(folder.string() + " has several COLMAP models; pass one of them, such as " +
                     below.front().string());
  return below.empty() ? folder : below.front();
}

/// Images with their lenses, sorted by name.
std::vector<NamedView> ReadNamedViews(const fs::path& folder) {
  const bool binary = fs::exists(folder / "images.bin");
  if (!binary && !fs::exists(folder / "images.txt"))
    throw InputError(folder.string() +
                     " has neither images.bin nor images.txt: it is not a COLMAP model folder");
  const std::string extension = binary ? ".bin" : ".txt";
  const fs::path cameras_file = folder / ("cameras" + extension),
                 images_file = folder / ("images" + extension);
  const Cameras cameras = binary ? ReadCamerasBinary(cameras_file) : ReadCamerasText(cameras_file);
  auto views =
      binary ? ReadImagesBinary(images_file, cameras) : ReadImagesText(images_file, cameras);
  std::sort(views.begin(), views.end(),
            [](const auto& a, const auto& b) { return a.view.name < b.view.name; });
  return views;
}

std::vector<SparsePoint> ReadPoints(const fs::path& folder,
                                    const std::map<std::uint32_t, int>& index_of) {
  const bool binary = fs::exists(folder / "images.bin");
  const fs::path file = folder / (binary ? "points3D.bin" : "points3D.txt");
  std::vector<SparsePoint> points;
  if (!fs::exists(file)) return points;
  for (RawPoint& raw : binary ? ReadPointsBinary(file) : ReadPointsText(file)) {
    for (const std::uint32_t id : raw.image_ids)
      if (const auto it = index_of.find(id); it != index_of.end())
        raw.point.views.push_back(it->second);
    std::sort(raw.point.views.begin(), raw.point.views.end());
    raw.point.views.erase(std::unique(raw.point.views.begin(), raw.point.views.end()),
                          raw.point.views.end());
    points.push_back(std::move(raw.point));
  }
  return points;
}

}  // namespace

bool HasColmapModel(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder, ignored) && IsModel(ModelFolder(folder));
}

std::vector<LensView> ReadColmapLenses(const fs::path& folder) {
  std::vector<LensView> views;
  for (NamedView& named : ReadNamedViews(ModelFolder(folder)))
    views.push_back(std::move(named.view));
  return views;
}

Scene ReadColmapModel(const fs::path& folder) {
  const fs::path model = ModelFolder(folder);
  Scene scene;
  std::map<std::uint32_t, int> index_of;
  std::map<std::uint32_t, Camera> usable;
  for (const NamedView& named : ReadNamedViews(model)) {
    index_of[named.id] = SizeOf(scene.views);
    auto camera = usable.find(named.camera);
    if (camera == usable.end()) {
      const std::string where = model.string() + ": camera " + std::to_string(named.camera);
      camera = usable.emplace(named.camera, UsableCamera(named.view.lens, where)).first;
    }
    scene.views.push_back({named.view.name, camera->second, named.view.camera_from_world});
  }
  scene.points = ReadPoints(model, index_of);
  return scene;
}

}  // namespace keypose
