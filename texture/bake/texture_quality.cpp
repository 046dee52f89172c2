#include "texture/bake/texture_quality.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/pictures/render.h"
#include "core/values/size_of.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

Image8 PlainHalf(const Image8& fine) {
  Image8 coarse(std::max(1, fine.width / 2), std::max(1, fine.height / 2), fine.channels);
  for (int y = 0; y < coarse.height; ++y)
    for (int x = 0; x < coarse.width; ++x)
      for (int c = 0; c < fine.channels; ++c) {
        const int x1 = std::min(2 * x + 1, fine.width - 1),
                  y1 = std::min(2 * y + 1, fine.height - 1);
        coarse.at(x, y)[c] =
            static_cast<std::uint8_t>((fine.at(2 * x, 2 * y)[c] + fine.at(x1, 2 * y)[c] +
                                       fine.at(2 * x, y1)[c] + fine.at(x1, y1)[c] + 2) /
                                      4);
      }
  return coarse;
}

/// Rendered and photographed colours on the grid of rays, linear light and sRGB.
struct Pair {
  std::vector<char> valid;
  std::vector<Vector3d> rendered;      ///< sRGB
  std::vector<Vector3f> photographed;  ///< linear
};

/// Intersection of a ray with the plane of a face that it is known to meet.
struct RayHit {
  double distance = 0;  ///< in lengths of the direction
  double u = 0, v = 0;  ///< weights of the second and third corner, within [0, 1] but for rounding
};
RayHit Meet(const Mesh& mesh, const Eigen::RowVector3i& face, const Vector3d& origin,
            const Vector3d& direction) {
  const Vector3d a = mesh.points.row(face[0]), ab = mesh.points.row(face[1]).transpose() - a,
                 ac = mesh.points.row(face[2]).transpose() - a;
  const Vector3d across = direction.cross(ac), from_a = origin - a, around = from_a.cross(ab);
  const double determinant = ab.dot(across);
  if (determinant == 0) return {};
  return {ac.dot(around) / determinant, from_a.dot(across) / determinant,
          direction.dot(around) / determinant};
}

Pair RenderInto(const Mesh& mesh, const TextureLevels& texture, int size, const BakeView& view) {
  const int width = view.rays_wide(), height = view.rays_high();
  Pair pair;
  pair.valid.assign(static_cast<std::size_t>(width) * height, 0);
  pair.rendered.assign(pair.valid.size(), Vector3d::Zero());
  pair.photographed.assign(pair.valid.size(), Vector3f::Zero());
  const double ray_width = std::exp2(view.RayLevel()) / view.view().camera.fx;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!view.RayIsGood(x, y)) continue;
      const auto f = mesh.faces.row(view.RayFace(x, y)), t = mesh.uv_faces.row(view.RayFace(x, y));
      const RayHit hit = Meet(mesh, f, view.center(), view.RayInWorld(x, y));
      const Vector2d uv = (1 - hit.u - hit.v) * mesh.uvs.row(t[0]) + hit.u * mesh.uvs.row(t[1]) +
                          hit.v * mesh.uvs.row(t[2]);
      // Texels under a pixel, in each direction, for a frontal surface; on a slanted one there are
      // more, but in one direction only.
      const double on_surface = (mesh.points.row(f[1]) - mesh.points.row(f[0])).norm();
      const double on_texture = (mesh.uvs.row(t[1]) - mesh.uvs.row(t[0])).norm() * size;
      const std::size_t i = static_cast<std::size_t>(y) * width + x;
      pair.rendered[i] = texture.Sample(
          uv, on_surface > 0 ? hit.distance * ray_width * on_texture / on_surface : 1);
      pair.photographed[i] = view.ColorAt(view.RayPixel(x, y).cast<float>(), view.RayLevel()).color;
      pair.valid[i] = 1;
    }
  return pair;
}

}  // namespace

TextureLevels::TextureLevels(Image8 texture) {
  levels_.push_back(std::move(texture));
  while (levels_.size() < 5 && levels_.back().width > 32)
    levels_.push_back(PlainHalf(levels_.back()));
}

Vector3d TextureLevels::Sample(const Vector2d& uv, double texels) const {
  const double level =
      std::clamp(std::log2(std::max(texels, 1e-6)), 0.0, static_cast<double>(levels_.size() - 1));
  const int below = std::min(static_cast<int>(level), SizeOf(levels_) - 1);
  const double t = level - below;
  const Vector3d fine = SampleTexture(levels_[below], uv);
  if (t < 0.02) return fine;
  return (1 - t) * fine + t * SampleTexture(levels_[below + 1], uv);
}

Comparison CompareToPhotograph(const Mesh& mesh, const TextureLevels& texture, int texture_size,
                               const BakeView& view) {
  Comparison result;
  if (view.sees_nothing()) return result;
  const Pair pair = RenderInto(mesh, texture, texture_size, view);
  Vector3d means[2] = {Vector3d::Zero(), Vector3d::Zero()};
  const auto linear = [](const Vector3d& srgb) {
    return Vector3f(LinearOf(static_cast<std::uint8_t>(std::lround(srgb[0]))),
                    LinearOf(static_cast<std::uint8_t>(std::lround(srgb[1]))),
                    LinearOf(static_cast<std::uint8_t>(std::lround(srgb[2]))));
  };
  for (std::size_t i = 0; i < pair.valid.size(); ++i) {
    if (!pair.valid[i]) continue;
    means[0] += linear(pair.rendered[i]).cast<double>();
    means[1] += pair.photographed[i].cast<double>();
    ++result.pixels;
  }
  if (result.pixels == 0) return result;
  const Vector3f gain = means[1].cwiseQuotient(means[0].cwiseMax(1e-9)).cast<float>();
  ImageT<double> rendered(view.rays_wide(), view.rays_high(), 1), photographed = rendered;
  double sum = 0, sum_gain = 0;
  for (std::size_t i = 0; i < pair.valid.size(); ++i) {
    if (!pair.valid[i]) continue;
    const Vector3f& p = pair.photographed[i];
    const Vector3f g = linear(pair.rendered[i]).cwiseProduct(gain);
    const Vector3d truth(SrgbOf(p[0]), SrgbOf(p[1]), SrgbOf(p[2])),
        regained(SrgbOf(g[0]), SrgbOf(g[1]), SrgbOf(g[2]));
    sum += (pair.rendered[i] - truth).squaredNorm();
    sum_gain += (regained - truth).squaredNorm();
    rendered.data[i] = Luma(pair.rendered[i].data());
    photographed.data[i] = Luma(truth.data());
  }
  result.psnr_db = Psnr(sum, 3.0 * result.pixels);
  result.psnr_gain_db = Psnr(sum_gain, 3.0 * result.pixels);
  result.ssim = Ssim(rendered, photographed, pair.valid);
  return result;
}

}  // namespace keypose::texture
