#include "texture/bake_quality.h"

#include <algorithm>
#include <cmath>

#include "core/render.h"

namespace keypose::texture {

double Psnr(double sum_of_squares, double count) {
  if (count <= 0) return 0;
  const double mean = sum_of_squares / count;
  return mean > 0 ? std::min(99.0, 10 * std::log10(255.0 * 255.0 / mean)) : 99.0;
}

Comparison CompareToPhotograph(const Mesh& mesh, const RayScene& scene, const Image8& texture, const BakeView& view,
                               const Eigen::Vector3f& gain) {
  Comparison result;
  if (view.sees_nothing()) return result;
  const Eigen::Matrix3d world_from_camera = view.view().camera_from_world.rotation.conjugate().toRotationMatrix();
  double sum = 0, sum_gain = 0;
  for (const Eigen::Vector2d& pixel : view.TrustedPixels(2)) {
    const RayScene::Hit hit = scene.Cast(view.center(), world_from_camera * view.view().camera.Unproject(pixel));
    if (hit.face < 0) continue;
    const double w[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
    for (int k = 0; k < 3; ++k) uv += w[k] * mesh.uvs.row(mesh.uv_faces(hit.face, k)).transpose();
    const Eigen::Vector3d rendered = SampleTexture(texture, uv);
    const Eigen::Vector3f photographed = view.ColorAt(pixel, 0).color;
    for (int c = 0; c < 3; ++c) {
      const double truth = SrgbOf(photographed[c]);
      const double regained = SrgbOf(LinearOf(static_cast<std::uint8_t>(std::lround(rendered[c]))) / gain[c]);
      sum += (rendered[c] - truth) * (rendered[c] - truth);
      sum_gain += (regained - truth) * (regained - truth);
    }
    ++result.pixels;
  }
  result.psnr_db = Psnr(sum, 3.0 * result.pixels);
  result.psnr_gain_db = Psnr(sum_gain, 3.0 * result.pixels);
  return result;
}

}  // namespace keypose::texture
