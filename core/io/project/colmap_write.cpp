#include "core/io/project/colmap_write.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

enum class ColmapModels {
  kOpenCv,          ///< all cameras are OPENCV
  kPinholeOrOpenCv  ///< those without distortion are PINHOLE
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

/// The numbers of a camera after its size, as its model has them.
using Key = std::array<double, 10>;
Key KeyOf(const Camera& c) {
  return {double(c.width), double(c.height), c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
}

/// The distinct cameras of the scene, numbered from 1 in the order of the views.
class SharedCameras {
 public:
  SharedCameras(const std::vector<View>& views, ColmapModels models) : models_(models) {
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
      cameras.Put<std::int32_t>(IsPinhole(key) ? 1 : 4);  // COLMAP's numbers
      cameras.Put<std::uint64_t>(static_cast<std::uint64_t>(key[0]));
      cameras.Put<std::uint64_t>(static_cast<std::uint64_t>(key[1]));
      for (std::size_t k = 2; k < EndOf(key); ++k) cameras.Put<double>(key[k]);
    }
    return cameras.bytes();
  }
  std::string Text() const {
    std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
    for (const Key& key : order_) {
      text += fmt::format("{} {} {:.0f} {:.0f}", ids_.at(key),
                          IsPinhole(key) ? "PINHOLE" : "OPENCV", key[0], key[1]);
      for (std::size_t k = 2; k < EndOf(key); ++k) text += fmt::format(" {}", key[k]);
      text += "\n";
    }
    return text;
  }

 private:
  bool IsPinhole(const Key& key) const {
    return models_ == ColmapModels::kPinholeOrOpenCv &&
           std::all_of(key.begin() + 6, key.end(), [](double number) { return number == 0; });
  }
  std::size_t EndOf(const Key& key) const { return IsPinhole(key) ? 6 : key.size(); }

  ColmapModels models_;
  std::map<Key, std::uint32_t> ids_;
  std::vector<Key> order_;
};

/// For each view, the points that it sees, in the order of its features. Each view gets one feature
/// for each of its tracks, at the point's projection, so that COLMAP's programs can read the model.
using SeenPoints = std::vector<std::vector<std::uint64_t>>;

SeenPoints SeenIn(const Scene& scene) {
  SeenPoints seen(scene.views.size());
  for (std::size_t p = 0; p < scene.points.size(); ++p)
    for (const int v : scene.points[p].views) seen[static_cast<std::size_t>(v)].push_back(p);
  return seen;
}

/// Calls put(view, feature) for each view of each point in turn.
template <class Begin, class Put>
void ForTracks(const Scene& scene, const Begin& begin, const Put& put) {
  std::vector<std::uint32_t> features(scene.views.size(), 0);
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    begin(p);
    for (const int v : scene.points[p].views)
      put(static_cast<std::uint32_t>(v + 1), features[static_cast<std::size_t>(v)]++);
  }
}

std::string PointsBytes(const Scene& scene) {
  BinaryWriter points;
  points.Put<std::uint64_t>(scene.points.size());
  const auto begin = [&](std::size_t p) {
    const SparsePoint& point = scene.points[p];
    points.Put<std::uint64_t>(p + 1);
    for (int k = 0; k < 3; ++k) points.Put<double>(point.position(k));
    for (int k = 0; k < 3; ++k) points.Put<std::uint8_t>(point.color(k));
    points.Put<double>(point.error_px);
    points.Put<std::uint64_t>(point.views.size());
  };
  ForTracks(scene, begin, [&](std::uint32_t image, std::uint32_t feature) {
    points.Put<std::uint32_t>(image);
    points.Put<std::uint32_t>(feature);
  });
  return points.bytes();
}

std::string PointsText(const Scene& scene) {
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)";
  const auto begin = [&](std::size_t p) {
    const SparsePoint& point = scene.points[p];
    const Eigen::Vector3d& x = point.position;
    text +=
        fmt::format("\n{} {} {} {} {} {} {} {}", p + 1, x.x(), x.y(), x.z(), int{point.color(0)},
                    int{point.color(1)}, int{point.color(2)}, point.error_px);
  };
  ForTracks(scene, begin, [&](std::uint32_t image, std::uint32_t feature) {
    text += fmt::format(" {} {}", image, feature);
  });
  return text + "\n";
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

std::string ImagesText(const Scene& scene, const SharedCameras& cameras, const SeenPoints& seen) {
  std::string text =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, "
      "POINT3D_ID)\n";
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const Eigen::Quaterniond& q = view.camera_from_world.rotation;
    const Eigen::Vector3d& t = view.camera_from_world.translation;
    text += fmt::format("{} {} {} {} {} {} {} {} {} {}\n", v + 1, q.w(), q.x(), q.y(), q.z(), t.x(),
                        t.y(), t.z(), cameras.IdOf(view.camera), view.name);
    const char* space = "";
    for (const std::uint64_t p : seen[v]) {
      const Eigen::Vector2d pixel = view.Project(scene.points[p].position);
      text += fmt::format("{}{} {} {}", space, pixel.x(), pixel.y(), p + 1);
      space = " ";
    }
    text += "\n";
  }
  return text;
}

void WriteBinary(const fs::path& folder, const Scene& scene, const SharedCameras& cameras) {
  WriteFile(folder / "cameras.bin", cameras.Bytes());
  WriteFile(folder / "images.bin", ImagesBytes(scene, cameras, SeenIn(scene)));
  WriteFile(folder / "points3D.bin", PointsBytes(scene));
}

void WriteText(const fs::path& folder, const Scene& scene, const SharedCameras& cameras) {
  WriteFile(folder / "cameras.txt", cameras.Text());
  WriteFile(folder / "images.txt", ImagesText(scene, cameras, SeenIn(scene)));
  WriteFile(folder / "points3D.txt", PointsText(scene));
}

bool HasSpace(const View& view) { return view.name.find_first_of(" \t\r\n") != std::string::npos; }

}  // namespace

void WriteColmapModel(const fs::path& folder, const Scene& scene) {
  WriteBinary(folder, scene, SharedCameras(scene.views, ColmapModels::kOpenCv));
}

void WriteColmapForOthers(const fs::path& folder, const Scene& scene) {
  const SharedCameras cameras(scene.views, ColmapModels::kPinholeOrOpenCv);
  WriteBinary(folder, scene, cameras);
  if (std::none_of(scene.views.begin(), scene.views.end(), HasSpace))
    WriteText(folder, scene, cameras);
}

}  // namespace keypose
