#include "texture/bake_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/errors.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kFar = 1e6f;
/// A step in depth of more than this many ray spacings is an edge; a plane makes such a step only when seen at less than 10 degrees.
constexpr double kDepthStepInCells = 6;

void CheckSizes(const View& view, const Photograph& photograph) {
  const auto check = [&](const Image8& image, const char* what) {
    if (image.width == view.camera.width && image.height == view.camera.height) return;
    throw InputError("bake: " + std::string(what) + " '" + view.name + "' has " + std::to_string(image.width) + " x " +
                     std::to_string(image.height) + " pixels, but the model's camera has " + std::to_string(view.camera.width) + " x " +
                     std::to_string(view.camera.height) + "; pass the images that the model was made from");
  };
  check(photograph.image, "image");
  if (photograph.image.channels != 3) throw InputError("bake: image '" + view.name + "' is not RGB");
  if (!photograph.mask.empty()) check(photograph.mask, "the mask of image");
}

/// Half the size; a pixel without any object in it stays without colour, and background never enters a mean.
Image8 Halved(const Image8& fine) {
  Image8 coarse((fine.width + 1) / 2, (fine.height + 1) / 2, 4);
  for (int y = 0; y < coarse.height; ++y)
    for (int x = 0; x < coarse.width; ++x) {
      Vector3f sum = Vector3f::Zero();
      float alpha = 0;
      for (int k = 0; k < 4; ++k) {
        const int fx = 2 * x + k % 2, fy = 2 * y + k / 2;
        if (fx >= fine.width || fy >= fine.height) continue;
        const std::uint8_t* p = fine.at(fx, fy);
        sum += static_cast<float>(p[3]) * Vector3f(LinearOf(p[0]), LinearOf(p[1]), LinearOf(p[2]));
        alpha += p[3];
      }
      std::uint8_t* out = coarse.at(x, y);
      for (int k = 0; k < 3; ++k) out[k] = alpha > 0 ? SrgbOf(sum[k] / alpha) : 0;
      out[3] = static_cast<std::uint8_t>(std::lround(alpha / 4));
    }
  return coarse;
}

/// Distance in cells to the nearest cell with 0 (chamfer 1, sqrt 2); cells beyond the border count as 0.
void DistanceToZero(ImageF& d) {
  const auto at = [&](int x, int y) { return x < 0 || y < 0 || x >= d.width || y >= d.height ? 0.0f : *d.at(x, y); };
  constexpr float kDiagonal = 1.41421356f;
  for (int y = 0; y < d.height; ++y)
    for (int x = 0; x < d.width; ++x)
      *d.at(x, y) = std::min({*d.at(x, y), at(x - 1, y) + 1, at(x, y - 1) + 1, at(x - 1, y - 1) + kDiagonal, at(x + 1, y - 1) + kDiagonal});
  for (int y = d.height - 1; y >= 0; --y)
    for (int x = d.width - 1; x >= 0; --x)
      *d.at(x, y) = std::min({*d.at(x, y), at(x + 1, y) + 1, at(x, y + 1) + 1, at(x + 1, y + 1) + kDiagonal, at(x - 1, y + 1) + kDiagonal});
}

bool IsObject(const Image8& mask, int x, int y) { return mask.empty() || *mask.at(x, y) > 127; }

/// Whether every mask pixel of a square around (x, y) is object.
bool AllObject(const Image8& mask, double x, double y, double half) {
  if (mask.empty()) return true;
  const int x0 = std::max(0, static_cast<int>(x - half)), x1 = std::min(mask.width - 1, static_cast<int>(x + half));
  const int y0 = std::max(0, static_cast<int>(y - half)), y1 = std::min(mask.height - 1, static_cast<int>(y + half));
  for (int py = y0; py <= y1; ++py)
    for (int px = x0; px <= x1; ++px)
      if (!IsObject(mask, px, py)) return false;
  return true;
}

}  // namespace

float LinearOf(std::uint8_t srgb) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t;
    for (int i = 0; i < 256; ++i) t[i] = static_cast<float>(i <= 10 ? i / 255.0 / 12.92 : std::pow((i / 255.0 + 0.055) / 1.055, 2.4));
    return t;
  }();
  return table[srgb];
}

std::uint8_t SrgbOf(float linear) {
  // A table over the square root: fine in the darks, where sRGB is steep.
  static const std::array<std::uint8_t, 4096> table = [] {
    std::array<std::uint8_t, 4096> t;
    for (int i = 0; i < 4096; ++i) {
      const double l = (i / 4095.0) * (i / 4095.0);
      t[i] = static_cast<std::uint8_t>(std::lround(255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055)));
    }
    return t;
  }();
  return table[static_cast<int>(std::sqrt(std::clamp(linear, 0.0f, 1.0f)) * 4095 + 0.5f)];
}

BakeView::BakeView(const View& view, const Photograph& photograph, const Mesh& mesh, const RayScene& scene, const BakeViewOptions& options)
    : view_(view), rotation_(view.camera_from_world.rotation.toRotationMatrix()), center_(view.Center()), sharpness_(photograph.sharpness) {
  CheckSizes(view, photograph);
  box_ = ProjectedBounds(mesh.points, view);
  if (box_.empty()) return;
  BuildPyramid(photograph, options);
  BuildDepth(photograph, scene, options);
}

void BakeView::BuildPyramid(const Photograph& photograph, const BakeViewOptions& options) {
  Image8 base(box_.x1 - box_.x0, box_.y1 - box_.y0, 4);
  double object_pixels = 0;
  for (int y = 0; y < base.height; ++y)
    for (int x = 0; x < base.width; ++x) {
      std::copy_n(photograph.image.at(box_.x0 + x, box_.y0 + y), 3, base.at(x, y));
      base.at(x, y)[3] = IsObject(photograph.mask, box_.x0 + x, box_.y0 + y) ? 255 : 0;
      object_pixels += base.at(x, y)[3] > 0;
    }
  for (; object_pixels > options.pixels_per_texel * options.texels; object_pixels /= 4) {
    base = Halved(base);
    ++base_level_;
  }
  levels_.push_back(std::move(base));
  for (int i = 0; i < 5; ++i) levels_.push_back(Halved(levels_.back()));
}

void BakeView::BuildDepth(const Photograph& photograph, const RayScene& scene, const BakeViewOptions& options) {
  const double area = static_cast<double>(box_.x1 - box_.x0) * (box_.y1 - box_.y0);
  cell_px_ = std::max(1.0, std::sqrt(area / options.depth_rays));
  cells_per_px_ = 1 / cell_px_;
  depth_step_ = kDepthStepInCells * cell_px_ / view_.camera.fx;
  cell_x0_ = static_cast<int>(box_.x0 / cell_px_);
  cell_y0_ = static_cast<int>(box_.y0 / cell_px_);
  const int width = static_cast<int>(std::ceil(box_.x1 / cell_px_)) - cell_x0_,
            height = static_cast<int>(std::ceil(box_.y1 / cell_px_)) - cell_y0_;
  depth_ = ImageF(width, height, 1, std::numeric_limits<float>::infinity());
  const Eigen::Matrix3d world_from_camera = rotation_.transpose();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vector2d pixel = RayPixel(x, y);
      const RayScene::Hit hit = scene.Cast(center_, world_from_camera * view_.camera.Unproject(pixel));
      if (hit.face >= 0) *depth_.at(x, y) = static_cast<float>(hit.distance);
    }
  MarkEdges(photograph, options);
}

void BakeView::MarkEdges(const Photograph& photograph, const BakeViewOptions& options) {
  trust_ = ImageF(depth_.width, depth_.height, 1, kFar);
  const auto depth_at = [&](int x, int y) {
    return x < 0 || y < 0 || x >= depth_.width || y >= depth_.height ? std::numeric_limits<float>::infinity() : *depth_.at(x, y);
  };
  for (int y = 0; y < depth_.height; ++y)
    for (int x = 0; x < depth_.width; ++x) {
      const float d = *depth_.at(x, y);
      bool edge = std::isinf(d) || !AllObject(photograph.mask, RayPixel(x, y).x(), RayPixel(x, y).y(), 0.5 * cell_px_);
      for (int k = 0; k < 4 && !edge; ++k)
        edge = !(std::abs(depth_at(x + (k == 0) - (k == 1), y + (k == 2) - (k == 3)) - d) < depth_step_ * d);
      if (edge) *trust_.at(x, y) = 0;
    }
  DistanceToZero(trust_);
  for (float& t : trust_.data) {
    // The first cell beyond an edge is half a cell away from it.
    const double beyond = ((t - 0.5) * cell_px_ - options.edge_guard_px) / std::max(options.edge_feather_px, 1e-6);
    t = static_cast<float>(std::clamp(beyond, 0.0, 1.0));
  }
}

float BakeView::Trust(const Vector2d& cell) const {
  const double x = std::clamp(cell.x() - 0.5, 0.0, trust_.width - 1.0), y = std::clamp(cell.y() - 0.5, 0.0, trust_.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y), x1 = std::min(x0 + 1, trust_.width - 1),
            y1 = std::min(y0 + 1, trust_.height - 1);
  const float fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  return (1 - fy) * ((1 - fx) * *trust_.at(x0, y0) + fx * *trust_.at(x1, y0)) +
         fy * ((1 - fx) * *trust_.at(x0, y1) + fx * *trust_.at(x1, y1));
}

Sighting BakeView::See(const Vector3d& x_in_world) const {
  Sighting sighting;
  const Vector3d x = rotation_ * x_in_world + view_.camera_from_world.translation;
  if (x.z() <= 0 || depth_.empty()) return sighting;
  sighting.pixel = view_.camera.Project(x);
  sighting.depth = x.z();
  sighting.trust = TrustAt(sighting.pixel, sighting.depth);
  return sighting;
}

float BakeView::TrustAt(const Vector2d& pixel, double depth) const {
  const Vector2d cell(pixel.x() * cells_per_px_ - cell_x0_, pixel.y() * cells_per_px_ - cell_y0_);
  if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < depth_.width && cell.y() < depth_.height)) return 0;
  const double surface = *depth_.at(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  return depth - surface < depth_step_ * depth ? Trust(cell) : 0;
}

Sample BakeView::Bilinear(int level, const Vector2d& pixel) const {
  const Image8& image = levels_[level];
  const double scale = 1.0 / (1 << (base_level_ + level));
  const double x = std::clamp((pixel.x() - box_.x0) * scale - 0.5, 0.0, image.width - 1.0);
  const double y = std::clamp((pixel.y() - box_.y0) * scale - 0.5, 0.0, image.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y), x1 = std::min(x0 + 1, image.width - 1),
            y1 = std::min(y0 + 1, image.height - 1);
  const float fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  const std::uint8_t* p[4] = {image.at(x0, y0), image.at(x1, y0), image.at(x0, y1), image.at(x1, y1)};
  const float w[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  Sample sample;
  for (int k = 0; k < 4; ++k) {
    const float a = w[k] * p[k][3];
    sample.color += a * Vector3f(LinearOf(p[k][0]), LinearOf(p[k][1]), LinearOf(p[k][2]));
    sample.alpha += a;
  }
  if (sample.alpha > 0) sample.color /= sample.alpha;
  sample.alpha /= 255;
  return sample;
}

Sample BakeView::ColorAt(const Vector2d& pixel, double level) const {
  const double stored = std::clamp(level - base_level_, 0.0, levels_.size() - 1.0);
  const int fine = static_cast<int>(stored);
  const float t = static_cast<float>(stored - fine);
  Sample a = Bilinear(fine, pixel);
  if (t < 0.02f || fine + 1 >= static_cast<int>(levels_.size())) return a;
  const Sample b = Bilinear(fine + 1, pixel);
  const float alpha = (1 - t) * a.alpha + t * b.alpha;
  if (alpha > 0) a.color = ((1 - t) * a.alpha * a.color + t * b.alpha * b.color) / alpha;
  a.alpha = alpha;
  return a;
}

ImageF BakeView::Detail(int level) const {
  constexpr int kBandLevels = 3;
  const Image8& fine = levels_[level];
  const int low = std::min(level + kBandLevels, static_cast<int>(levels_.size()) - 1);
  const double size = 1 << (base_level_ + level);
  ImageF detail(fine.width, fine.height, 1, std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      const std::uint8_t* p = fine.at(x, y);
      if (p[3] < 128) continue;
      const Sample around = Bilinear(low, Vector2d(box_.x0 + (x + 0.5) * size, box_.y0 + (y + 0.5) * size));
      if (!(around.alpha > 0)) continue;
      const auto luma = [](float r, float g, float b) { return std::sqrt(0.299f * r + 0.587f * g + 0.114f * b); };
      *detail.at(x, y) = luma(LinearOf(p[0]), LinearOf(p[1]), LinearOf(p[2])) - luma(around.color[0], around.color[1], around.color[2]);
    }
  return detail;
}

double BakeView::RayLevel() const { return std::log2(cell_px_); }

}  // namespace keypose::texture
