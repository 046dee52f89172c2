#include "bench/view_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/parallel.h"
#include "core/render.h"

namespace keypose::bench {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;

template <class A, class B>
void RequireSameSize(const ImageT<A>& a, const ImageT<B>& b, const char* what) {
  if (a.width != b.width || a.height != b.height)
    throw InputError(std::string(what) + " differ in size: " + std::to_string(a.width) + " x " + std::to_string(a.height) + " and " +
                     std::to_string(b.width) + " x " + std::to_string(b.height) + " pixels");
}

bool Masked(const Image8& mask, int x, int y) { return *mask.at(x, y) >= 128; }

double Ratio(long part, long whole, bool nothing_anywhere) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : nothing_anywhere ? 1 : 0;
}

using Plane = std::vector<double>;

std::array<double, 2 * kRadius + 1> Window() {
  std::array<double, 2 * kRadius + 1> window;
  for (int i = -kRadius; i <= kRadius; ++i) window[static_cast<std::size_t>(i + kRadius)] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  return window;
}

/// Separable weighted sums; beyond the border there is nothing.
Plane Blurred(const Plane& plane, int width, int height) {
  const auto window = Window();
  Plane rows(plane.size()), result(plane.size());
  ParallelFor(height, [&](std::int64_t y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int i = std::max(-kRadius, -x); i <= std::min(kRadius, width - 1 - x); ++i)
        sum += window[static_cast<std::size_t>(i + kRadius)] * plane[static_cast<std::size_t>(y * width + x + i)];
      rows[static_cast<std::size_t>(y * width + x)] = sum;
    }
  });
  ParallelFor(height, [&](std::int64_t y) {
    const int row = static_cast<int>(y);
    for (int i = std::max(-kRadius, -row); i <= std::min(kRadius, height - 1 - row); ++i)
      for (int x = 0; x < width; ++x)
        result[static_cast<std::size_t>(y * width + x)] +=
            window[static_cast<std::size_t>(i + kRadius)] * rows[static_cast<std::size_t>((y + i) * width + x)];
  });
  return result;
}

PixelBox MaskedBox(const Image8& mask) {
  PixelBox box{mask.width, mask.height, 0, 0};
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (Masked(mask, x, y)) box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1), std::max(box.y1, y + 1)};
  return box;
}

double Luma(const std::uint8_t* rgb) { return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2]; }

/// Sums that the index needs, each weighted by window and mask: 1, a, b, aa, bb, ab.
std::array<Plane, 6> WindowSums(const Image8& a, const Image8& b, const Image8& mask, const PixelBox& box) {
  const int width = box.x1 - box.x0, height = box.y1 - box.y0;
  std::array<Plane, 6> sums;
  for (Plane& plane : sums) plane.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!Masked(mask, box.x0 + x, box.y0 + y)) continue;
      const double la = Luma(a.at(box.x0 + x, box.y0 + y)), lb = Luma(b.at(box.x0 + x, box.y0 + y));
      const double values[6] = {1, la, lb, la * la, lb * lb, la * lb};
      for (std::size_t k = 0; k < 6; ++k) sums[k][static_cast<std::size_t>(y * width + x)] = values[k];
    }
  for (Plane& plane : sums) plane = Blurred(plane, width, height);
  return sums;
}

double SimilarityAt(const std::array<Plane, 6>& sums, std::size_t i) {
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255, kC2 = 0.03 * 255 * 0.03 * 255;
  const double n = sums[0][i], ma = sums[1][i] / n, mb = sums[2][i] / n;
  const double aa = sums[3][i] / n - ma * ma, bb = sums[4][i] / n - mb * mb, ab = sums[5][i] / n - ma * mb;
  return (2 * ma * mb + kC1) * (2 * ab + kC2) / ((ma * ma + mb * mb + kC1) * (aa + bb + kC2));
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

/// The mask without the pixels that the mesh does not fill.
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
  for (std::size_t i = 0; i < covered.data.size(); ++i) covered.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
  return covered;
}

ColorRender RenderColors(const TexturedMesh& mesh, const RayScene& scene, const View& view, int samples) {
  const Camera& camera = view.camera;
  ColorRender render{ImageF(camera.width, camera.height, 3), ImageF(camera.width, camera.height, 1)};
  const PixelBox box = ProjectedBounds(mesh.mesh.points, view);
  const Eigen::Matrix3d world_from_camera = view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d eye = view.Center();
  ParallelFor(std::max(0, box.y1 - box.y0), [&](std::int64_t row) {
    const int y = box.y0 + static_cast<int>(row);
    for (int x = box.x0; x < box.x1; ++x) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int hits = 0;
      for (int s = 0; s < samples * samples; ++s) {
        const Eigen::Vector2d pixel(x + (s % samples + 0.5) / samples, y + (s / samples + 0.5) / samples);
        const RayScene::Hit hit = scene.Cast(eye, world_from_camera * camera.Unproject(pixel));
        if (hit.face < 0) continue;
        sum += mesh.ColorAt(hit.face, hit.u, hit.v);
        ++hits;
      }
      for (int c = 0; c < 3; ++c) render.color.at(x, y)[c] = static_cast<float>(sum[c] / (samples * samples));
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
    while (value < 255 && 2 * (below += histogram[static_cast<std::size_t>(c)][static_cast<std::size_t>(value)]) < count) ++value;
    if (count > 0) median[c] = value;
  }
  return median;
}

Image8 Composed(const ColorRender& render, const Eigen::Vector3d& background, const Eigen::Vector3d& gain) {
  Image8 image(render.color.width, render.color.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const int c = static_cast<int>(i % 3);
    const double value = gain[c] * render.color.data[i] + (1 - render.covered.data[i / 3]) * background[c];
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
  const Eigen::Vector3d background = BackgroundColor(photograph, mask), gain = BestGain(photograph, mask, render);
  const Image8 plain = Composed(render, background), gained = Composed(render, background, gain);
  score.psnr_db = MaskedPsnr(photograph, plain, mask, score.pixels);
  score.ssim = Ssim(photograph, plain, mask);
  std::copy_n(gain.data(), 3, score.gain);
  score.gained_psnr_db = MaskedPsnr(photograph, gained, mask, score.pixels);
  score.gained_ssim = Ssim(photograph, gained, mask);
  const Image8 filled = Filled(mask, render);
  if (const long pixels = CountMasked(filled)) score.filled_psnr_db = MaskedPsnr(photograph, gained, filled, pixels);
  return score;
}

double Ssim(const Image8& a, const Image8& b, const Image8& mask) {
  RequireSameSize(a, b, "images");
  RequireSameSize(a, mask, "image and mask");
  const PixelBox box = MaskedBox(mask);
  if (box.empty()) return 1;
  const std::array<Plane, 6> sums = WindowSums(a, b, mask, box);
  double total = 0;
  long count = 0;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      if (!Masked(mask, x, y)) continue;
      total += SimilarityAt(sums, static_cast<std::size_t>((y - box.y0) * (box.x1 - box.x0) + x - box.x0));
      ++count;
    }
  return total / static_cast<double>(count);
}

double Psnr(double sum_of_squares, double count) {
  const double mean = sum_of_squares / count;
  return mean > 0 ? std::min(99.0, 10 * std::log10(255.0 * 255.0 / mean)) : 99.0;
}

}  // namespace keypose::bench
