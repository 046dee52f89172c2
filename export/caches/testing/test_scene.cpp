#include "export/caches/testing/test_scene.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/io/pictures/png_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"

namespace keypose::exporting {
namespace {

namespace fs = std::filesystem;

// u goes once around the tube, so corners beyond the seam have u > 1 - 1/segments or u near 0.
void AddUvs(Mesh& mesh, int segments) {
  mesh.uvs.resize(3 * mesh.face_count(), 2);
  mesh.uv_faces.resize(mesh.face_count(), 3);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const auto turn = [&](int k) {
      const Eigen::RowVector3d p = mesh.points.row(mesh.faces(f, k));
      const double angle = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi);
      return std::round((angle < 0 ? angle + 1 : angle) * segments) / segments;
    };
    for (int k = 0; k < 3; ++k) {
      double u = turn(k);
      if (u < 0.5 && std::max(turn((k + 1) % 3), turn((k + 2) % 3)) > 0.7) u += 1;
      mesh.uvs.row(3 * f + k) << 0.05 + 0.7 * u, 0.1 + 0.2 * mesh.points(mesh.faces(f, k), 2);
      mesh.uv_faces(f, k) = 3 * f + k;
    }
  }
}

PointsX3 Bent(const PointsX3& rest, double amount) {
  PointsX3 points = rest;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const double x = rest(v, 0), y = rest(v, 1), z = rest(v, 2), turn = 0.07 * amount * z;
    points(v, 0) = std::cos(turn) * x - std::sin(turn) * y + 0.05 * amount * z * z;
    points(v, 1) = 0.6 * (std::sin(turn) * x + std::cos(turn) * y) + 0.03 * amount;
  }
  return points;
}

/// Bands in three colours, so that a swapped axis shows.
Image8 Bands() {
  Image8 image(64, 64, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      std::uint8_t* pixel = image.at(x, y);
      pixel[0] = static_cast<std::uint8_t>(60 + 3 * x);
      pixel[1] = static_cast<std::uint8_t>((x / 8) % 2 ? 170 : 90);
      pixel[2] = static_cast<std::uint8_t>(60 + 3 * y);
    }
  }
  return image;
}

/// The content of a PNG file with this picture.
std::string PngBytes(const Image8& image) {
  const TestingFolder folder;
  WritePng(folder.path() / "bands.png", image);
  return ReadFile(folder.path() / "bands.png");
}

template <class Values>
void AppendRaw(std::string& bytes, const Values& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()),
               sizeof(values.data()[0]) * static_cast<std::size_t>(values.size()));
}

/// Per shown frame: 1 if its picture is held until the next.
std::vector<int> StandsOfShown(const Scene& scene) {
  std::vector<int> stands;
  const std::vector<Moment> moments = PlaybackMoments(scene.clip, scene.playback);
  const int count = SizeOf(ShownFrames(scene));
  for (int i = 0; i < count; ++i) {
    std::size_t m = 0;  // the moment that the frame belongs to
    while (m + 1 < moments.size() && moments[m + 1].seconds * scene.playback.fps < i + 1e-6) ++m;
    const bool held =
        m + 1 < moments.size() && (moments[m].stands || moments[m].frame == moments[m + 1].frame);
    stands.push_back(held);
  }
  return stands;
}

}  // namespace

Scene TestScene(const TestSceneOptions& options) {
  Mesh mesh = MakeCylinder(1, 4, options.segments, options.rings);
  if (options.with_uvs) AddUvs(mesh, options.segments);
  Scene scene;
  for (std::size_t i = 0; i < options.bends.size(); ++i) {
    Mesh frame = mesh;
    frame.points = Bent(mesh.points, options.bends[i]);
    scene.frames.push_back(frame);
    scene.frame_names.push_back("frame_000" + std::to_string(i));
  }
  scene.net = NetOf(mesh, {});
  scene.split = MakeAnimatedMesh(scene.frames, scene.frame_names);
  scene.clip = MakeClip(scene.split.points, options.stands, false);
  scene.playback = options.playback;
  scene.z_up = options.z_up;
  if (!options.with_uvs) return scene;
  scene.texture_pixels = {Bands()};
  scene.textures = {{PngBytes(scene.texture_pixels[0]), "image/png", "bands"}};
  scene.poses = {"rest"};
  return scene;
}

void WriteFiles(const FormatFiles& made, const Scene& scene, const fs::path& folder) {
  for (const FormatFile& file : made.files) {
    fs::create_directories((folder / file.path).parent_path());
    WriteFile(folder / file.path, file.bytes);
  }
  fs::create_directories(folder / "textures");
  for (int i = 0; i < SizeOf(scene.textures); ++i)
    WriteFile(folder / "textures" / scene.textures[i].FileName(i), scene.textures[i].bytes);
}

void WriteTruth(const Scene& scene, const fs::path& folder) {
  const std::vector<int> shown = ShownFrames(scene);
  const Mesh& mesh = scene.frames[0];
  const nlohmann::json truth = {
      {"frames", shown.size()},         {"vertices", mesh.vertex_count()},
      {"faces", mesh.face_count()},     {"split_vertices", scene.split.source_vertex.size()},
      {"fps", scene.playback.fps},      {"diagonal", SceneDiagonal(scene)},
      {"stands", StandsOfShown(scene)}, {"shown", shown}};
  std::string points, normals, faces, corner_uvs, source;
  for (const int frame : shown) {
    AppendRaw(points, WithYUp(scene.frames[frame].points, scene.z_up));
    AppendRaw(normals, WithYUp(scene.split.normals[frame], scene.z_up));
  }
  AppendRaw(faces, mesh.faces);
  AppendRaw(source, scene.split.source_vertex);
  if (mesh.has_uvs()) {
    for (int f = 0; f < mesh.face_count(); ++f)
      for (int k = 0; k < 3; ++k)
        AppendRaw(corner_uvs, Eigen::RowVector2d(mesh.uvs.row(mesh.uv_faces(f, k))));
  }
  fs::create_directories(folder);
  WriteFile(folder / "truth.json", truth.dump(1));
  WriteFile(folder / "points.f64", points);
  WriteFile(folder / "faces.i32", faces);
  WriteFile(folder / "corner_uvs.f64", corner_uvs);
  WriteFile(folder / "split_source.i32", source);
  WriteFile(folder / "split_normals.f64", normals);
}

}  // namespace keypose::exporting
