#include "export/blender/blender_files.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written as they are in memory");

constexpr int kPc2HeaderBytes = 32;

template <class Number>
void Append(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The frames without those that show the same as the one before them.
struct Pictures {
  std::vector<int> frame;     ///< of each picture, its first frame
  std::vector<int> of_frame;  ///< the picture of each frame
};

Pictures FindPictures(const Scene& scene) {
  const auto same_as_before = [&](int i) {
    const bool same_points = scene.clip.picture[i] == scene.clip.picture[i - 1];
    return same_points && (scene.texture_weights.empty() ||
                           scene.texture_weights[i] == scene.texture_weights[i - 1]);
  };
  Pictures pictures;
  for (int i = 0; i < scene.frame_count(); ++i) {
    if (i == 0 || !same_as_before(i)) pictures.frame.push_back(i);
    pictures.of_frame.push_back(SizeOf(pictures.frame) - 1);
  }
  return pictures;
}

/// Blender has z up: (x, y, z) -> (x, -z, y) where y was.
Eigen::Vector3d WithZUp(const Eigen::Vector3d& point, bool z_up) {
  return z_up ? point : Eigen::Vector3d(point.x(), -point.z(), point.y());
}

/// Autodesk's POINTCACHE2: signature, version, points, start, samples a frame, samples; positions.
std::string Pc2Of(const Scene& scene, const Pictures& pictures, Progress* progress) {
  const int vertex_count = scene.frames[0].vertex_count();
  std::string bytes("POINTCACHE2\0", 12);
  bytes.reserve(kPc2HeaderBytes + sizeof(float) * 3 * vertex_count * pictures.frame.size());
  Append<std::int32_t>(bytes, 1);
  Append<std::int32_t>(bytes, vertex_count);
  Append<float>(bytes, 0);
  Append<float>(bytes, 1);
  Append<std::int32_t>(bytes, SizeOf(pictures.frame));
  for (std::size_t i = 0; i < pictures.frame.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(pictures.frame.size()),
                   "writing Blender's cache");
    for (int v = 0; v < vertex_count; ++v) {
      const Eigen::Vector3d point = scene.frames[pictures.frame[i]].points.row(v);
      const Eigen::Vector3f placed = WithZUp(point, scene.z_up).cast<float>();
      for (int axis = 0; axis < 3; ++axis) Append(bytes, placed[axis]);
    }
  }
  return bytes;
}

/// Largest distance of a vertex of any frame from where the cache has it.
double WorstError(const Scene& scene, const Pictures& pictures, const std::string& pc2) {
  const int vertex_count = scene.frames[0].vertex_count();
  double worst = 0;
  for (int i = 0; i < scene.frame_count(); ++i) {
    for (int v = 0; v < vertex_count; ++v) {
      Eigen::Vector3f held;
      const std::size_t row = static_cast<std::size_t>(pictures.of_frame[i]) * vertex_count + v;
      std::memcpy(held.data(), pc2.data() + kPc2HeaderBytes + sizeof(held) * row, sizeof(held));
      const Eigen::Vector3d point = scene.frames[i].points.row(v);
      worst = std::max(worst, (held.cast<double>() - WithZUp(point, scene.z_up)).norm());
    }
  }
  return worst;
}

std::string CornersAndUvs(const Mesh& mesh) {
  std::string bytes;
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) Append<std::int32_t>(bytes, mesh.faces(f, k));
  for (int f = 0; mesh.has_uvs() && f < mesh.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      Append(bytes, static_cast<float>(mesh.uvs(mesh.uv_faces(f, k), 0)));
      Append(bytes, static_cast<float>(mesh.uvs(mesh.uv_faces(f, k), 1)));
    }
  }
  return bytes;
}

nlohmann::json Times(const Scene& scene, const Pictures& pictures) {
  nlohmann::json out = {{"moments", nlohmann::json::array()}, {"keys", nlohmann::json::array()}};
  for (const Moment& moment : PlaybackMoments(scene.clip, scene.playback)) {
    out["moments"].push_back({{"seconds", moment.seconds},
                              {"picture", pictures.of_frame[moment.frame]},
                              {"stands", moment.stands}});
  }
  const std::vector<double> seconds = KeySeconds(scene);
  for (std::size_t i = 0; i < scene.keys.size(); ++i)
    out["keys"].push_back({{"seconds", seconds[i]}, {"pose", scene.keys[i].pose}});
  return out;
}

nlohmann::json Description(const Scene& scene, const Pictures& pictures) {
  nlohmann::json out = Times(scene, pictures);
  out["schema"] = 1;
  out["name"] = scene.name;
  out["fps"] = scene.playback.fps;
  out["loops"] = Loops(scene);
  out["shown_frames"] = SizeOf(ShownFrames(scene));
  out["pictures"] = SizeOf(pictures.frame);
  out["vertices"] = scene.frames[0].vertex_count();
  out["faces"] = scene.frames[0].face_count();
  out["has_uvs"] = scene.frames[0].has_uvs();
  out["textures"] = nlohmann::json::array();
  out["weights"] = nlohmann::json::array();
  const bool blends = !scene.texture_weights.empty();
  for (int i = 0; i < SizeOf(scene.textures) && (blends || i == 0); ++i) {
    const std::string name = i == 0 ? FirstTextureFile(scene) : scene.textures[i].FileName(i);
    out["textures"].push_back({{"file", "../textures/" + name}, {"pose", scene.poses[i]}});
  }
  if (!blends) return out;
  for (const int frame : pictures.frame) out["weights"].push_back(scene.texture_weights[frame]);
  return out;
}

}  // namespace

FormatFiles MakeBlenderFiles(const Scene& scene, Progress* progress) {
  const Pictures pictures = FindPictures(scene);
  const std::string pc2 = Pc2Of(scene, pictures, progress);
  FormatFiles made;
  made.error_over_diagonal = WorstError(scene, pictures, pc2) / SceneDiagonal(scene);
  made.measured["pictures"] = SizeOf(pictures.frame);
  made.files = {{"blender/keypose_import.py", std::string(BlenderAddOn())},
                {"blender/character.json", Description(scene, pictures).dump(1) + "\n"},
                {"blender/character.bin", CornersAndUvs(scene.frames[0])},
                {"blender/character.pc2", pc2}};
  return made;
}

}  // namespace keypose::exporting
