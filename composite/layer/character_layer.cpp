#include "composite/layer/character_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"

namespace keypose::composite {
namespace {

using Eigen::Vector3d;

/// Bilinear light of the texture at (u right, v up).
Vector3d TextureLight(const ImageF& texture, const Eigen::Vector2d& uv) {
  const double x = std::clamp(uv[0] * texture.width - 0.5, 0.0, texture.width - 1.0),
               y = std::clamp((1 - uv[1]) * texture.height - 0.5, 0.0, texture.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, texture.width - 1), y1 = std::min(y0 + 1, texture.height - 1);
  const double fx = x - x0, fy = y - y0;
  const float *a = texture.at(x0, y0), *b = texture.at(x1, y0), *c = texture.at(x0, y1),
              *d = texture.at(x1, y1);
  Vector3d light;
  for (int k = 0; k < 3; ++k)
    light[k] = (1 - fy) * ((1 - fx) * a[k] + fx * b[k]) + fy * ((1 - fx) * c[k] + fx * d[k]);
  return light;
}

Vector3d LightAt(const Character& character, const PointsX3& gains, const RayScene::Hit& hit) {
  const std::array<double, 3> w{1 - hit.u - hit.v, hit.u, hit.v};
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  Vector3d gain = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    uv += w[k] * character.uvs.row(character.uv_faces(hit.face, k)).transpose();
    if (gains.rows()) gain += w[k] * gains.row(character.faces(hit.face, k)).transpose();
  }
  const Vector3d light = TextureLight(character.texture, uv);
  return gains.rows() ? light.cwiseProduct(gain) : light;
}

}  // namespace

ImageF RenderLayer(const Character& character, const PointsX3& points, const RayScene& scene,
                   const PointsX3& gains, const View& view, const PixelRays& rays, int along,
                   const Ground* table, const RayScene* props) {
  ImageF layer(view.camera.width, view.camera.height, 4);
  const PixelBox box = ProjectedBounds(points, view);
  const Rigid3 world_from_camera = view.camera_from_world.Inverse();
  const Eigen::Matrix3d turn = world_from_camera.rotation.toRotationMatrix();
  const Vector3d& eye = world_from_camera.translation;
  const double height = table ? (eye - table->origin).dot(table->up) : 0;
  // Distance at which a ray from above reaches the table; beyond any hit where it does not.
  const auto to_table = [&](const Vector3d& ray) {
    const double down = table ? -ray.dot(table->up) : 0;
    return height > 0 && down > 0 ? height / down : std::numeric_limits<double>::infinity();
  };
  const auto row = [&](std::int64_t line) {
    const int y = static_cast<int>(line);
    for (int x = box.x0; x < box.x1; ++x) {
      Vector3d sum = Vector3d::Zero();
      int hits = 0;
      for (int i = 0; i < along * along; ++i) {
        const Vector3d ray =
            turn * rays.At(x, y, (i % along + 0.5) / along, (i / along + 0.5) / along);
        const RayScene::Hit hit = scene.Cast(eye, ray, 0, to_table(ray));
        if (hit.face < 0 || (props && props->Occluded(eye, ray, 0, hit.distance))) continue;
        sum += LightAt(character, gains, hit);
        ++hits;
      }
      float* pixel = layer.at(x, y);
      for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(sum[c] / (along * along));
      pixel[3] = static_cast<float>(hits) / static_cast<float>(along * along);
    }
  };
  ParallelFor(
      box.y1 - box.y0, [&](std::int64_t i) { row(box.y0 + i); }, 4);
  return layer;
}

}  // namespace keypose::composite
