#include "core/io/project/colmap_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <numeric>
#include <sstream>

#include "core/io/pictures/image_kind.h"
#include "core/io/text/files.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

struct Model {
  int id;
  const char* name;
  std::size_t parameters;
};
constexpr std::array<Model, 5> kModels{{{0, "SIMPLE_PINHOLE", 3},
                                        {1, "PINHOLE", 4},
                                        {2, "SIMPLE_RADIAL", 4},
                                        {3, "RADIAL", 5},
                                        {4, "OPENCV", 8}}};

Camera CameraFrom(int model, std::uint64_t width, std::uint64_t height,
                  const std::vector<double>& p) {
  Camera camera;
  camera.width = static_cast<int>(std::min(width, std::uint64_t{kMostPixels}));
  camera.height = static_cast<int>(std::min(height, std::uint64_t{kMostPixels}));
  const bool one_focal = model == 0 || model == 2 || model == 3;
  camera.fx = p[0];
  camera.fy = one_focal ? p[0] : p[1];
  const std::size_t at = one_focal ? 1 : 2;
  camera.cx = p[at];
  camera.cy = p[at + 1];
  if (p.size() > at + 2) camera.k1 = p[at + 2];
  if (p.size() > at + 3) camera.k2 = p[at + 3];
  if (p.size() > at + 5) {
    camera.p1 = p[at + 4];
    camera.p2 = p[at + 5];
  }
  return camera;
}

const Model& FindModel(const std::string& name_or_id, const fs::path& where) {
  for (const Model& model : kModels)
    if (name_or_id == model.name || name_or_id == std::to_string(model.id)) return model;
  throw InputError(
      where.string() + ": camera model " + name_or_id +
      " is not supported; use SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL or OPENCV");
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

class BinaryWriter {
 public:
  template <class T>
  void Put(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void PutString(const std::string& text) { bytes_.append(text.c_str(), text.size() + 1); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

using Cameras = std::map<std::uint32_t, Camera>;
struct NamedView {
  std::uint32_t id;
  View view;
};

Cameras ReadCamerasBinary(const fs::path& path) {
  BinaryReader in(path);
  Cameras cameras;
  const auto count = in.Get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = in.Get<std::uint32_t>();
    const Model& model = FindModel(std::to_string(in.Get<std::int32_t>()), path);
    const auto width = in.Get<std::uint64_t>(), height = in.Get<std::uint64_t>();
    std::vector<double> parameters(model.parameters);
    for (double& p : parameters) p = in.Get<double>();
    cameras[id] = CameraFrom(model.id, width, height, parameters);
    RequireUsableCamera(cameras[id], path.string() + ": camera " + std::to_string(id));
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

const Camera& CameraOf(const Cameras& cameras, std::uint32_t id, const fs::path& path) {
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
    named.view.camera = CameraOf(cameras, in.Get<std::uint32_t>(), path);
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

/// Lines that are not comments. Images keep their empty feature lines.
std::vector<std::string> DataLines(const fs::path& path, bool keep_empty) {
  std::istringstream in(ReadFile(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    if (!(line.rfind('#', 0) == 0) && (keep_empty || !line.empty())) lines.push_back(line);
  return lines;
}

[[noreturn]] void ThrowLine(const fs::path& path, const std::string& line) {
  throw InputError(path.string() + ": cannot read the line '" + line.substr(0, 80) + "'");
}

Cameras ReadCamerasText(const fs::path& path) {
  Cameras cameras;
  for (const std::string& line : DataLines(path, false)) {
    std::istringstream in(line);
    std::uint32_t id = 0;
    std::string name;
    std::uint64_t width = 0, height = 0;
    if (!(in >> id >> name >> width >> height)) ThrowLine(path, line);
    const Model& model = FindModel(name, path);
    std::vector<double> parameters(model.parameters);
    for (double& p : parameters)
      if (!(in >> p)) ThrowLine(path, line);
    cameras[id] = CameraFrom(model.id, width, height, parameters);
    RequireUsableCamera(cameras[id], path.string() + ": camera " + std::to_string(id));
  }
  return cameras;
}

std::vector<NamedView> ReadImagesText(const fs::path& path, const Cameras& cameras) {
  std::vector<NamedView> views;
  const auto lines = DataLines(path, true);
  for (std::size_t i = 0; i < lines.size(); i += 2) {
    if (lines[i].empty()) break;
    std::istringstream in(lines[i]);
    NamedView named;
    std::array<double, 7> pose{};
    std::uint32_t camera = 0;
    in >> named.id;
    for (double& p : pose) in >> p;
    if (!(in >> camera >> std::ws) || !std::getline(in, named.view.name)) ThrowLine(path, lines[i]);
    named.view.camera_from_world =
        PoseFrom(pose, path.string() + ": image " + std::to_string(named.id));
    named.view.camera = CameraOf(cameras, camera, path);
    views.push_back(std::move(named));
  }
  return views;
}

std::vector<RawPoint> ReadPointsText(const fs::path& path) {
  std::vector<RawPoint> points;
  for (const std::string& line : DataLines(path, false)) {
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

}  // namespace

void RequireUsableCamera(const Camera& camera, const std::string& where) {
  constexpr double kMost = 1e7,
                   kLeastFocal = 1e-2;  // in pixels; also far above any distortion coefficient
  const std::array<double, 8> numbers{camera.fx, camera.fy, camera.cx, camera.cy,
                                      camera.k1, camera.k2, camera.p1, camera.p2};
  const auto usable = [](double number) { return std::abs(number) <= kMost; };  // false for NaN
  if (!std::all_of(numbers.begin(), numbers.end(), usable) || !(camera.fx > kLeastFocal) ||
      !(camera.fy > kLeastFocal))
    throw InputError(where +
                     " has an impossible focal length, centre or distortion (not finite, 0, or "
                     "beyond 1e7); it is damaged: run sfm again");
  if (camera.width < 1 || camera.height < 1 ||
      std::int64_t{camera.width} * camera.height > kMostPixels)
    throw InputError(where + " is for pictures of " + std::to_string(camera.width) + " x " +
                     std::to_string(camera.height) +
                     " pixels, which is not possible; it is damaged: run sfm again");
}

Scene ReadColmapModel(const fs::path& folder) {
  const bool binary = fs::exists(folder / "images.bin");
  if (!binary && !fs::exists(folder / "images.txt"))
    throw InputError(folder.string() +
                     " has neither images.bin nor images.txt: it is not a COLMAP model folder");
  const std::string extension = binary ? ".bin" : ".txt";
  const fs::path cameras_file = folder / ("cameras" + extension),
                 images_file = folder / ("images" + extension),
                 points_file = folder / ("points3D" + extension);
  const Cameras cameras = binary ? ReadCamerasBinary(cameras_file) : ReadCamerasText(cameras_file);
  auto views =
      binary ? ReadImagesBinary(images_file, cameras) : ReadImagesText(images_file, cameras);
  std::sort(views.begin(), views.end(),
            [](const auto& a, const auto& b) { return a.view.name < b.view.name; });
  Scene scene;
  std::map<std::uint32_t, int> index_of;
  for (NamedView& named : views) {
    index_of[named.id] = SizeOf(scene.views);
    scene.views.push_back(std::move(named.view));
  }
  if (!fs::exists(points_file)) return scene;
  for (RawPoint& raw : binary ? ReadPointsBinary(points_file) : ReadPointsText(points_file)) {
    for (const std::uint32_t id : raw.image_ids)
      if (const auto it = index_of.find(id); it != index_of.end())
        raw.point.views.push_back(it->second);
    std::sort(raw.point.views.begin(), raw.point.views.end());
    raw.point.views.erase(std::unique(raw.point.views.begin(), raw.point.views.end()),
                          raw.point.views.end());
    scene.points.push_back(std::move(raw.point));
  }
  return scene;
}

namespace {

/// The distinct cameras of the scene, numbered from 1 in the order of the views.
class SharedCameras {
 public:
  explicit SharedCameras(const std::vector<View>& views) {
    for (const View& view : views)
      if (ids_.emplace(KeyOf(view.camera), static_cast<std::uint32_t>(order_.size() + 1)).second)
        order_.push_back(KeyOf(view.camera));
  }
  std::uint32_t IdOf(const Camera& camera) const { return ids_.at(KeyOf(camera)); }
  std::string Bytes() const {
    BinaryWriter cameras;
    cameras.Put<std::uint64_t>(order_.size());
    for (const Key& key : order_) {
      cameras.Put<std::uint32_t>(ids_.at(key));
      cameras.Put<std::int32_t>(4);  // COLMAP's model OPENCV
      cameras.Put<std::uint64_t>(static_cast<std::uint64_t>(key[0]));
      cameras.Put<std::uint64_t>(static_cast<std::uint64_t>(key[1]));
      for (std::size_t k = 2; k < key.size(); ++k) cameras.Put<double>(key[k]);
    }
    return cameras.bytes();
  }

 private:
  using Key = std::array<double, 10>;
  static Key KeyOf(const Camera& c) {
    return {double(c.width), double(c.height), c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
  }
  std::map<Key, std::uint32_t> ids_;
  std::vector<Key> order_;
};

/// For each view, the points that it sees, in the order of its features. Each view gets one feature
/// for each of its tracks, at the point's projection, so that COLMAP's programs can read the model.
using SeenPoints = std::vector<std::vector<std::uint64_t>>;

std::string PointsBytes(const Scene& scene, SeenPoints& seen) {
  BinaryWriter points;
  points.Put<std::uint64_t>(scene.points.size());
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    const SparsePoint& point = scene.points[p];
    points.Put<std::uint64_t>(p + 1);
    for (int k = 0; k < 3; ++k) points.Put<double>(point.position(k));
    for (int k = 0; k < 3; ++k) points.Put<std::uint8_t>(point.color(k));
    points.Put<double>(point.error_px);
    points.Put<std::uint64_t>(point.views.size());
    for (const int v : point.views) {
      points.Put<std::uint32_t>(static_cast<std::uint32_t>(v + 1));
      points.Put<std::uint32_t>(static_cast<std::uint32_t>(seen[v].size()));
      seen[v].push_back(p);
    }
  }
  return points.bytes();
}

std::string ImagesBytes(const Scene& scene, const SharedCameras& cameras, const SeenPoints& seen) {
  BinaryWriter images;
  images.Put<std::uint64_t>(scene.views.size());
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const Rigid3& pose = view.camera_from_world;
    images.Put<std::uint32_t>(static_cast<std::uint32_t>(v + 1));
    for (const double q :
         {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()})
      images.Put<double>(q);
    for (int k = 0; k < 3; ++k) images.Put<double>(pose.translation(k));
    images.Put<std::uint32_t>(cameras.IdOf(view.camera));
    images.PutString(view.name);
    images.Put<std::uint64_t>(seen[v].size());
    for (const std::uint64_t p : seen[v]) {
      const Eigen::Vector2d pixel = view.Project(scene.points[p].position);
      images.Put<double>(pixel.x());
      images.Put<double>(pixel.y());
      images.Put<std::uint64_t>(p + 1);
    }
  }
  return images.bytes();
}

}  // namespace

void WriteColmapModel(const fs::path& folder, const Scene& scene) {
  const SharedCameras cameras(scene.views);
  SeenPoints seen(scene.views.size());
  const std::string points = PointsBytes(scene, seen);
  WriteFile(folder / "cameras.bin", cameras.Bytes());
  WriteFile(folder / "images.bin", ImagesBytes(scene, cameras, seen));
  WriteFile(folder / "points3D.bin", points);
}

}  // namespace keypose
