#include "export/film/film.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/geometry.h"
#include "core/parallel.h"
#include "core/render.h"

namespace keypose::exporting {
namespace {

constexpr double kElevationDeg = 12;

Eigen::Vector3d Up(const FilmOptions& options) {
  return options.z_up ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
}

/// A camera whose picture contains all frames.
View CameraOf(const std::vector<Mesh>& frames, double azimuth_deg, const FilmOptions& options) {
  Eigen::Index rows = 0;
  for (const Mesh& frame : frames) rows += frame.points.rows();
  PointsX3 all(rows, 3);
  rows = 0;
  for (const Mesh& frame : frames) {
    all.middleRows(rows, frame.points.rows()) = frame.points;
    rows += frame.points.rows();
  }
  return FitView(all, azimuth_deg, kElevationDeg, options.width, options.height, Up(options));
}

/// Sum of the motion across the picture from frame to frame, over vertices that face the camera,
/// weighted by how much they face it.
double MotionSeen(const std::vector<Mesh>& frames, const std::vector<PointsX3>& normals,
                  const Eigen::Matrix3d& camera_from_world) {
  std::vector<double> seen(frames.size(), 0);
  ParallelFor(std::ssize(frames) - 1, [&](std::int64_t i) {
    for (Eigen::Index v = 0; v < frames[i].points.rows(); ++v) {
      const double facing = -(camera_from_world.row(2).dot(normals[i].row(v)));
      if (facing <= 0) continue;
      const Eigen::RowVector3d way = frames[i + 1].points.row(v) - frames[i].points.row(v);
      seen[i] += facing * (camera_from_world.topRows<2>() * way.transpose()).norm();
    }
  });
  double sum = 0;
  for (const double one : seen) sum += one;
  return sum;
}

Image8 Blended(const std::vector<Image8>& textures, const std::vector<double>& weights) {
  Image8 blended = textures[0];
  const auto size = std::ssize(blended.data);
  ParallelBlocks(size, 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      double sum = 0.5;
      for (std::size_t k = 0; k < textures.size(); ++k) sum += weights[k] * textures[k].data[i];
      blended.data[i] = static_cast<std::uint8_t>(std::clamp(sum, 0.0, 255.0));
    }
  });
  return blended;
}

bool SameSize(const std::vector<Image8>& textures) {
  return std::all_of(textures.begin(), textures.end(), [&](const Image8& texture) {
    return texture.width == textures[0].width && texture.height == textures[0].height &&
           texture.channels == textures[0].channels;
  });
}

Image8 RenderFrame(const FilmScene& scene, int frame, const View& view) {
  Mesh mesh = scene.frames[frame];
  mesh.uvs = scene.frames[0].uvs;
  mesh.uv_faces = scene.frames[0].uv_faces;
  RenderOptions look;
  look.samples = 2;
  look.shading = 0.35;  // the texture already contains the photographs' light
  const bool textured = mesh.has_uvs() && !scene.textures.empty();
  const bool blends = textured && !scene.blend.empty() && SameSize(scene.textures);
  Image8 texture;
  if (blends) texture = Blended(scene.textures, scene.blend[frame]);
  if (textured)
    look.texture = blends ? &texture : &scene.textures[0];
  else
    look.plain = mesh.colors.rows() == 0, look.shading = 1;
  return Render(mesh, view, look);
}

}  // namespace

double AzimuthOfMotion(const std::vector<Mesh>& frames, const FilmOptions& options) {
  std::vector<PointsX3> normals(frames.size());
  ParallelFor(std::ssize(frames), [&](std::int64_t i) {
    normals[i] = VertexNormals(frames[i].points, frames[0].faces);
  });
  // The first photograph usually shows the character's face, which sfm turns to -y. The film is
  // taken from that half.
  constexpr int kStep = 15, kWidest = 75;
  double best = 20, most = 0;
  for (int turn = -kWidest; turn <= kWidest; turn += kStep) {
    const int azimuth = (turn + 360) % 360;
    const View view = FitView(frames[0].points, azimuth, kElevationDeg, options.width,
                              options.height, Up(options));
    const double seen =
        MotionSeen(frames, normals, view.camera_from_world.rotation.toRotationMatrix());
    if (seen > most * (1 + 1e-9)) most = seen, best = azimuth;
  }
  return best;
}

void RenderFilm(const FilmScene& scene, const std::vector<int>& order, const FilmOptions& options,
                const std::function<void(const Image8&)>& take, Progress* progress) {
  const double azimuth =
      options.azimuth_deg >= 0 ? options.azimuth_deg : AzimuthOfMotion(scene.frames, options);
  const View view = CameraOf(scene.frames, azimuth, options);
  Image8 picture;
  for (std::size_t i = 0; i < order.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(order.size()),
                   "rendering the film");
    if (i == 0 || order[i] != order[i - 1]) picture = RenderFrame(scene, order[i], view);
    take(picture);
  }
}

}  // namespace keypose::exporting
