// Painted spheres, cameras around them and their photographs, for the tests of baking.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/pictures/srgb16.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"
#include "texture/bake/bake.h"
#include "texture/bake/texture_quality.h"
#include "views/atlas/atlas.h"

namespace keypose::texture {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// A sphere as six n x n patches, each a chart of a 3 x 2 layout with margins; vertices are shared
/// across the charts' seams.
inline Mesh PatchSphere(int n, double radius = 1, const Vector3d& center = Vector3d::Zero()) {
  std::vector<Vector3d> points;
  std::vector<Vector2d> uvs;
  std::vector<Eigen::Vector3i> faces, uv_faces;
  std::map<std::array<long, 3>, int> known;
  const auto vertex = [&](const Vector3d& cube) {
    const std::array<long, 3> key = {std::lround(cube.x() * 1e6), std::lround(cube.y() * 1e6),
                                     std::lround(cube.z() * 1e6)};
    const auto [it, added] = known.try_emplace(key, SizeOf(points));
    if (added) points.push_back(center + radius * cube.normalized());
    return it->second;
  };
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 ? -1 : 1;
    std::vector<int> v, t;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        Vector3d cube;
        cube[axis] = sign;
        // Equal angles, so that the faces have about the same size; swapped on the back so that all
        // face outwards.
        cube[(axis + 1) % 3] = std::tan((2.0 * i / n - 1) * M_PI / 4) * sign;
        cube[(axis + 2) % 3] = std::tan((2.0 * j / n - 1) * M_PI / 4);
        v.push_back(vertex(cube));
        t.push_back(SizeOf(uvs));
        uvs.emplace_back((side % 3 + 0.06 + 0.88 * i / n) / 3,
                         (side / 3 + 0.06 + 0.88 * j / n) / 2);
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        for (const Eigen::Vector3i& q : {Eigen::Vector3i(a, b, d), Eigen::Vector3i(a, d, c)}) {
          faces.emplace_back(v[q[0]], v[q[1]], v[q[2]]);
          uv_faces.emplace_back(t[q[0]], t[q[1]], t[q[2]]);
        }
      }
  }
  Mesh mesh;
  mesh.points.resize(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.points.row(i) = points[i];
  mesh.uvs.resize(uvs.size(), 2);
  for (std::size_t i = 0; i < uvs.size(); ++i) mesh.uvs.row(i) = uvs[i];
  mesh.faces.resize(faces.size(), 3);
  mesh.uv_faces.resize(faces.size(), 3);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    mesh.faces.row(i) = faces[i];
    mesh.uv_faces.row(i) = uv_faces[i];
  }
  return mesh;
}

/// Linear colour of a surface point seen from an eye.
using Paint = std::function<Vector3f(const Vector3d& x, const Vector3d& eye)>;

inline Vector3f Smooth(const Vector3d& x, const Vector3d&) {
  return Vector3f(0.35f + 0.25f * static_cast<float>(std::sin(4 * x.x() + 1)),
                  0.4f + 0.25f * static_cast<float>(std::cos(5 * x.y() - 2 * x.z())),
                  0.3f + 0.2f * static_cast<float>(std::sin(3 * x.z() + 2 * x.x())));
}

inline Vector3f Checker(const Vector3d& x, const Vector3d&) {
  const int parity =
      static_cast<int>(std::floor(x.x() * 2 + 100.3) + std::floor(x.y() * 2 + 100.3) +
                       std::floor(x.z() * 2 + 100.3)) %
      2;
  return parity ? Vector3f(0.5f, 0.35f, 0.2f) : Vector3f(0.12f, 0.2f, 0.3f);
}

inline View At(const Vector3d& eye, int size) {
  View view;
  view.camera.width = size * 4 / 3;
  view.camera.height = size;
  view.camera.fx = view.camera.fy = 1.55 * size;
  view.camera.cx = size * 2 / 3.0 + 1.5;
  view.camera.cy = size / 2.0 - 2.5;
  view.camera.k1 = -0.08;
  view.camera.p1 = 0.002;
  view.camera_from_world = LookAt(eye, Vector3d::Zero());
  return view;
}

inline bool AwayFromCheckerEdges(const Vector3d& x) {
  double nearest = 1;
  for (int k = 0; k < 3; ++k)
    nearest = std::min(nearest, std::abs(x[k] * 2 + 100.3 - std::round(x[k] * 2 + 100.3)) / 2);
  return nearest > 0.02;
}

/// Two rings of cameras around the unit sphere, one camera above and one below.
inline std::vector<View> AllRound(int size, int around = 8) {
  std::vector<View> views;
  for (int ring = 0; ring < 2; ++ring)
    for (int i = 0; i < around; ++i) {
      const double a = 2 * M_PI * (i + 0.5 * ring) / around, e = ring ? 0.6 : -0.6;
      views.push_back(At(
          4 * Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)), size));
    }
  views.push_back(At({0.01, 0, 4}, size));
  views.push_back(At({0.01, 0, -4}, size));
  for (std::size_t i = 0; i < views.size(); ++i)
    views[i].name = "view_" + std::to_string(i) + ".png";
  return views;
}

/// Photographs with 2 x 2 rays per pixel on the mesh; the background is white, so that its
/// influence would be visible.
/// @param deep  of 16 bits, not 8
inline std::vector<Photograph> Shoot(const Mesh& mesh, const std::vector<View>& views,
                                     const Paint& paint, bool deep = false) {
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<Photograph> photographs(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Camera& c = views[v].camera;
    Photograph& photograph = photographs[v];
    if (deep)
      photograph.deep = Image16(c.width, c.height, 3);
    else
      photograph.image = Image8(c.width, c.height, 3);
    photograph.mask = Image8(c.width, c.height, 1);
    const Vector3d eye = views[v].Center();
    const Eigen::Matrix3d world_from_camera =
        views[v].camera_from_world.rotation.conjugate().toRotationMatrix();
    ParallelFor(c.height, [&](std::int64_t row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < c.width; ++x) {
        Vector3f sum = Vector3f::Zero();
        int hits = 0;
        // Lens distortion is linear within a pixel, so it is solved for one ray of the pixel only.
        const Vector3d middle = world_from_camera * c.Unproject({x + 0.5, y + 0.5});
        for (int s = 0; s < 4; ++s) {
          const Vector3d direction =
              middle + world_from_camera *
                           Vector3d((s % 2 - 0.5) / (2 * c.fx), (s / 2 - 0.5) / (2 * c.fy), 0);
          const RayScene::Hit hit = scene.Cast(eye, direction);
          sum += hit.face < 0 ? Vector3f::Ones() : paint(eye + hit.distance * direction, eye);
          hits += hit.face >= 0;
        }
        for (int k = 0; k < 3; ++k)
          if (deep)
            photograph.deep.at(x, y)[k] = Srgb16Of(sum[k] / 4);
          else
            photograph.image.at(x, y)[k] = SrgbOf(sum[k] / 4);
        *photograph.mask.at(x, y) = hits >= 2 ? 255 : 0;
      }
    });
  }
  return photographs;
}

/// PatchSphere(12) from AllRound(240), smooth or checkered: several tests share these photographs.
inline const std::vector<Photograph>& SharedPhotographs(bool checkered) {
  static const std::vector<Photograph> smooth = Shoot(PatchSphere(12), AllRound(240), Smooth);
  static const std::vector<Photograph> checker = Shoot(PatchSphere(12), AllRound(240), Checker);
  return checkered ? checker : smooth;
}

inline BakeOptions Small() {
  BakeOptions options;
  options.texture_size = 384;
  return options;
}

inline BakeResult BakeAll(const Mesh& mesh, const std::vector<View>& views,
                          const std::vector<Photograph>& photographs,
                          const BakeOptions& options = Small()) {
  return Bake(
      mesh, views, [&](int i) { return photographs[i]; }, options);
}

/// 8-bit PSNR of the texture against the paint, over texels in triangles for which `where` holds.
inline double PsnrAgainst(
    const Mesh& mesh, const Image8& texture, const Paint& truth,
    const std::function<bool(const Vector3d&)>& where = [](const Vector3d&) { return true; }) {
  const Atlas atlas = RasterizeAtlas(mesh, texture.width);
  double sum = 0, count = 0;
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (!atlas.inside[texel]) continue;
    const Vector3d w = atlas.Weights(texel).cast<double>();
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      x += w[k] * mesh.points.row(mesh.faces(atlas.face[texel], k)).transpose();
    if (!where(x)) continue;
    const Vector3f color = truth(x, Vector3d::Zero());
    for (int k = 0; k < 3; ++k) {
      sum += std::pow(texture.data[3 * texel + k] - static_cast<double>(SrgbOf(color[k])), 2);
      ++count;
    }
  }
  EXPECT_GT(count, 1000);
  return Psnr(sum, count);
}

/// The same for the paint averaged over a square of `texels` around each texel's centre: the best
/// that a camera of that footprint can resolve of a hard edge. A square that extends beyond its
/// texel's face continues in the face's plane.
inline double FootprintPsnrAgainst(const Mesh& mesh, const Image8& texture, const Paint& truth,
                                   double texels) {
  constexpr int kSamples = 8;
  const Atlas fine = RasterizeAtlas(mesh, texture.width);
  double sum = 0, count = 0;
  for (int y = 0; y < fine.size; ++y)
    for (int x = 0; x < fine.size; ++x) {
      const std::size_t texel = static_cast<std::size_t>(y) * fine.size + x;
      if (!fine.inside[texel]) continue;
      const int f = fine.face[texel];
      Eigen::Matrix3d corners;  // columns: u, v, 1 of the corners, in texels
      for (int k = 0; k < 3; ++k) {
        const auto uv = mesh.uvs.row(mesh.uv_faces(f, k));
        corners.col(k) = Vector3d(uv[0] * fine.size, (1 - uv[1]) * fine.size, 1);
      }
      const Eigen::Matrix3d weights_of = corners.inverse();
      Vector3f mean = Vector3f::Zero();
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const Vector3d at(x + 0.5 + texels * ((s % kSamples + 0.5) / kSamples - 0.5),
                          y + 0.5 + texels * ((s / kSamples + 0.5) / kSamples - 0.5), 1);
        const Vector3d w = weights_of * at;
        Vector3d point = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) point += w[k] * mesh.points.row(mesh.faces(f, k)).transpose();
        mean += truth(point, Vector3d::Zero()) / (kSamples * kSamples);
      }
      for (int k = 0; k < 3; ++k) {
        sum += std::pow(texture.data[3 * texel + k] - static_cast<double>(SrgbOf(mean[k])), 2);
        ++count;
      }
    }
  EXPECT_GT(count, 1000);
  return Psnr(sum, count);
}

}  // namespace keypose::texture
