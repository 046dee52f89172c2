#include "bench/view_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/pictures/image_quality.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"

namespace keypose::bench {
namespace {

template <class A, class B>
void RequireSameSize(const ImageT<A>& a, const ImageT<B>& b, const char* what) {
  if (a.width != b.width || a.height != b.height)
    throw InputError(std::string(what) + " differ in size: " + std::to_string(a.width) + " x " +
                     std::to_string(a.height) + " and " + std::to_string(b.width) + " x " +
                     std::to_string(b.height) + " pixels");
}

bool Masked(const Image8& mask, int x, int y) { return *mask.at(x, y) >= 128; }

double Ratio(long part, long whole, bool nothing_anywhere) {
  return whole > 0          ? static_cast<double>(part) / static_cast<double>(whole)
         : nothing_anywhere ? 1
                            : 0;
}

ImageT<double> LumaOf(const Image8& rgb) {
  ImageT<double> luma(rgb.width, rgb.height, 1);
  for (std::size_t i = 0; i < luma.data.size(); ++i) luma.data[i] = Luma(&rgb.data[3 * i]);
  return luma;
}

double MaskedPsnr(const Image8& a, const Image8& b, const Image8& mask, long pixels) {
  double sum = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      for (int c = 0; c < 3 && Masked(mask, x, y); ++c) {
        const double difference = static_cast<double>(a.at(x, y)[c]) - b.at(x, y)[c];
        sum += difference * difference;
      }
  return Psnr(sum, 3.0 * static_cast<double>(pixels));
}

/// The mask, without the pixels that the mesh does not fill.
Image8 Filled(const Image8& mask, const ColorRender& render) {
  Image8 filled = mask;
  for (std::size_t i = 0; i < filled.data.size(); ++i)
    if (render.covered.data[i] < 1) filled.data[i] = 0;
  return filled;
}

long CountMasked(const Image8& mask) {
  return std::count_if(mask.data.begin(), mask.data.end(), [](std::uint8_t m) { return m >= 128; });
}

Eigen::Vector3d BestGain(const Image8& photograph, const Image8& mask, const ColorRender& render) {
  Eigen::Vector3d product = Eigen::Vector3d::Zero(), square = Eigen::Vector3d::Zero();
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (!Masked(mask, x, y) || *render.covered.at(x, y) < 1) continue;
      for (int c = 0; c < 3; ++c) {
        const double r = render.color.at(x, y)[c];
        product[c] += r * photograph.at(x, y)[c];
        square[c] += r * r;
      }
    }
  Eigen::Vector3d gain;
  for (int c = 0; c < 3; ++c) gain[c] = square[c] > 0 ? product[c] / square[c] : 1;
  return gain;
}

}  // namespace

double Silhouette::Iou() const { return Ratio(both, both + mask_only + mesh_only, true); }
double Silhouette::Precision() const { return Ratio(both, both + mesh_only, mask_only == 0); }
double Silhouette::Recall() const { return Ratio(both, both + mask_only, mesh_only == 0); }

Silhouette CompareSilhouettes(const Image8& mask, const Image8& covered) {
  RequireSameSize(mask, covered, "mask and render");
  Silhouette result;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const bool in_mask = Masked(mask, x, y), in_mesh = *covered.at(x, y) != 0;
      result.both += in_mask && in_mesh;
      result.mask_only += in_mask && !in_mesh;
      result.mesh_only += !in_mask && in_mesh;
    }
  return result;
}

Image8 CoveredPixels(const TexturedMesh& mesh, const RayScene& scene, const View& view) {
  const Raster raster = Rasterize(mesh.mesh, scene, view);
  Image8 covered(view.camera.width, view.camera.height, 1);
  for (std::size_t i = 0; i < covered.data.size(); ++i)
    covered.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
  return covered;
}

ColorRender RenderColors(const TexturedMesh& mesh, const RayScene& scene, const View& view,
                         int samples) {
  const Camera& camera = view.camera;
  ColorRender render{ImageF(camera.width, camera.height, 3),
                     ImageF(camera.width, camera.height, 1)};
  const PixelBox box = ProjectedBounds(mesh.mesh.points, view);
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d eye = view.Center();
  ParallelFor(std::max(0, box.y1 - box.y0), [&](std::int64_t row) {
    const int y = box.y0 + static_cast<int>(row);
    for (int x = box.x0; x < box.x1; ++x) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int hits = 0;
      for (int s = 0; s < samples * samples; ++s) {
        const Eigen::Vector2d pixel(x + (s % samples + 0.5) / samples,
                                    y + (s / samples + 0.5) / samples);
        const RayScene::Hit hit = scene.Cast(eye, world_from_camera * camera.Unproject(pixel));
        if (hit.face < 0) continue;
        sum += mesh.ColorAt(hit.face, hit.u, hit.v);
        ++hits;
      }
      for (int c = 0; c < 3; ++c)
        render.color.at(x, y)[c] = static_cast<float>(sum[c] / (samples * samples));
      *render.covered.at(x, y) = static_cast<float>(hits) / static_cast<float>(samples * samples);
    }
  });
  return render;
}

Eigen::Vector3d BackgroundColor(const Image8& photograph, const Image8& mask) {
  std::array<std::array<long, 256>, 3> histogram{};
  long count = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (Masked(mask, x, y)) continue;
      ++count;
      for (std::size_t c = 0; c < 3; ++c) ++histogram[c][photograph.at(x, y)[c]];
    }
  Eigen::Vector3d median = Eigen::Vector3d::Zero();
  for (int c = 0; c < 3; ++c) {
    long below = 0;
    int value = 0;
    while (value < 255 && 2 * (below += histogram[c][value]) < count) ++value;
    if (count > 0) median[c] = value;
  }
  return median;
}

Image8 Composed(const ColorRender& render, const Eigen::Vector3d& background,
                const Eigen::Vector3d& gain) {
  Image8 image(render.color.width, render.color.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const int c = static_cast<int>(i % 3);
    const double value =
        gain[c] * render.color.data[i] + (1 - render.covered.data[i / 3]) * background[c];
    image.data[i] = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
  }
  return image;
}

ColorScore CompareColors(const Image8& photograph, const Image8& mask, const ColorRender& render) {
  RequireSameSize(photograph, mask, "photograph and mask");
  RequireSameSize(photograph, render.color, "photograph and render");
  ColorScore score;
  score.pixels = CountMasked(mask);
  if (score.pixels == 0) return score;
  const Eigen::Vector3d background = BackgroundColor(photograph, mask),
                        gain = BestGain(photograph, mask, render);
  const Image8 plain = Composed(render, background), gained = Composed(render, background, gain);
  score.psnr_db = MaskedPsnr(photograph, plain, mask, score.pixels);
  score.ssim = Ssim(photograph, plain, mask);
  std::copy_n(gain.data(), 3, score.gain);
  score.gained_psnr_db = MaskedPsnr(photograph, gained, mask, score.pixels);
  score.gained_ssim = Ssim(photograph, gained, mask);
  const Image8 filled = Filled(mask, render);
  if (const long pixels = CountMasked(filled))
    score.filled_psnr_db = MaskedPsnr(photograph, gained, filled, pixels);
  return score;
}

double Ssim(const Image8& a, const Image8& b, const Image8& mask) {
  RequireSameSize(a, b, "images");
  RequireSameSize(a, mask, "image and mask");
  std::vector<char> valid(mask.data.size());
  for (std::size_t i = 0; i < valid.size(); ++i) valid[i] = mask.data[i] >= 128;
  return keypose::Ssim(LumaOf(a), LumaOf(b), valid);
}

}  // namespace keypose::bench
