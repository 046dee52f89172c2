#include "texture/bake/bake_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/pictures/srgb.h"
#include "core/pictures/srgb16.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kFar = 1e6f;
/// A depth difference of more than this many ray spacings is an edge; a plane has such a difference
/// only at less than 10 degrees to the ray.
constexpr double kDepthStepInCells = 6;
/// Distance between rays with stored directions; those between are interpolated.
constexpr int kRayStep = 8;

void CheckSizes(const View& view, const Photograph& photograph) {
  const auto check = [&](const auto& image, const char* what) {
    if (image.width == view.camera.width && image.height == view.camera.height) return;
    throw InputError("bake: " + std::string(what) + " '" + view.name + "' has " +
                     std::to_string(image.width) + " x " + std::to_string(image.height) +
                     " pixels, but the model's camera has " + std::to_string(view.camera.width) +
                     " x " + std::to_string(view.camera.height) +
                     "; pass the images that the model was made from");
  };
  const bool deep = !photograph.deep.empty();
  deep ? check(photograph.deep, "image") : check(photograph.image, "image");
  if ((deep ? photograph.deep.channels : photograph.image.channels) != 3)
    throw InputError("bake: image '" + view.name + "' is not RGB");
  if (!photograph.mask.empty()) check(photograph.mask, "the mask of image");
}

/// Stored values to linear light, and back.
const float* TableOf(std::uint8_t) { return kLinear.data(); }
const float* TableOf(std::uint16_t) { return LinearTable16(); }
void Store(float linear, std::uint8_t* srgb) { *srgb = SrgbOf(linear); }
void Store(float linear, std::uint16_t* srgb) { *srgb = Srgb16Of(linear); }

/// Half the size. A pixel without object pixels has no colour, and background is never averaged.
template <class T>
ImageT<T> Halved(const ImageT<T>& fine) {
  const float* light = TableOf(T{});
  ImageT<T> coarse((fine.width + 1) / 2, (fine.height + 1) / 2, 4);
  for (int y = 0; y < coarse.height; ++y)
    for (int x = 0; x < coarse.width; ++x) {
      Vector3f sum = Vector3f::Zero();
      float alpha = 0;
      for (int k = 0; k < 4; ++k) {
        const int fx = 2 * x + k % 2, fy = 2 * y + k / 2;
        if (fx >= fine.width || fy >= fine.height) continue;
        const T* p = fine.at(fx, fy);
        sum += static_cast<float>(p[3]) * Vector3f(light[p[0]], light[p[1]], light[p[2]]);
        alpha += static_cast<float>(p[3]);
      }
      T* out = coarse.at(x, y);
      for (int k = 0; k < 3; ++k)
        if (alpha > 0) Store(sum[k] / alpha, &out[k]);
      out[3] = static_cast<T>(std::lround(alpha / 4));
    }
  return coarse;
}

/// Distance in cells to the nearest cell with 0 (chamfer 1, sqrt 2); cells beyond the border count
/// as 0.
void DistanceToZero(ImageF& d) {
  const auto at = [&](int x, int y) {
    return x < 0 || y < 0 || x >= d.width || y >= d.height ? 0.0f : *d.at(x, y);
  };
  constexpr float kDiagonal = 1.41421356f;
  for (int y = 0; y < d.height; ++y)
    for (int x = 0; x < d.width; ++x)
      *d.at(x, y) = std::min({*d.at(x, y), at(x - 1, y) + 1, at(x, y - 1) + 1,
                              at(x - 1, y - 1) + kDiagonal, at(x + 1, y - 1) + kDiagonal});
  for (int y = d.height - 1; y >= 0; --y)
    for (int x = d.width - 1; x >= 0; --x)
      *d.at(x, y) = std::min({*d.at(x, y), at(x + 1, y) + 1, at(x, y + 1) + 1,
                              at(x + 1, y + 1) + kDiagonal, at(x - 1, y + 1) + kDiagonal});
}

bool IsObject(const Image8& mask, int x, int y) { return mask.empty() || *mask.at(x, y) > 127; }

/// Whether all mask pixels of a square around (x, y) are object.
bool AllObject(const Image8& mask, double x, double y, double half) {
  if (mask.empty()) return true;
  const int x0 = std::max(0, static_cast<int>(x - half)),
            x1 = std::min(mask.width - 1, static_cast<int>(x + half));
  const int y0 = std::max(0, static_cast<int>(y - half)),
            y1 = std::min(mask.height - 1, static_cast<int>(y + half));
  for (int py = y0; py <= y1; ++py)
    for (int px = x0; px <= x1; ++px)
      if (!IsObject(mask, px, py)) return false;
  return true;
}

}  // namespace

BakeView::BakeView(const View& view, const Photograph& photograph, const Mesh& mesh,
                   const RayScene& scene, const BakeViewOptions& options)
    : view_(view),
      rotation_(view.camera_from_world.rotation.toRotationMatrix()),
      center_(view.Center()),
      sharpness_(photograph.sharpness) {
  CheckSizes(view, photograph);
  box_ = ProjectedBounds(mesh.points, view);
  if (box_.empty()) return;
  BuildPyramid(photograph, options);
  BuildDepth(photograph, scene, options);
}

template <class T>
std::vector<ImageT<T>> BakeView::Pyramid(const ImageT<T>& image, const Image8& mask,
                                         const BakeViewOptions& options) {
  ImageT<T> base(box_.x1 - box_.x0, box_.y1 - box_.y0, 4);
  double object_pixels = 0;
  for (int y = 0; y < base.height; ++y)
    for (int x = 0; x < base.width; ++x) {
      std::copy_n(image.at(box_.x0 + x, box_.y0 + y), 3, base.at(x, y));
      base.at(x, y)[3] =
          IsObject(mask, box_.x0 + x, box_.y0 + y) ? std::numeric_limits<T>::max() : T{0};
      object_pixels += base.at(x, y)[3] > 0;
    }
  for (; object_pixels > options.pixels_per_texel * options.texels; object_pixels /= 4) {
    base = Halved(base);
    ++base_level_;
  }
  std::vector<ImageT<T>> levels;
  levels.push_back(std::move(base));
  for (int i = 0; i < 5; ++i) levels.push_back(Halved(levels.back()));
  return levels;
}

void BakeView::BuildPyramid(const Photograph& photograph, const BakeViewOptions& options) {
  if (photograph.deep.empty()) {
    levels_ = Pyramid(photograph.image, photograph.mask, options);
  } else {
    deep_levels_ = Pyramid(photograph.deep, photograph.mask, options);
    deep_linear_ = LinearTable16();
  }
  const int count = std::max(SizeOf(levels_), SizeOf(deep_levels_));
  for (int i = 0; i < count; ++i)
    scales_.push_back(1.0f / static_cast<float>(1 << (base_level_ + i)));
}

void BakeView::BuildDepth(const Photograph& photograph, const RayScene& scene,
                          const BakeViewOptions& options) {
  const double area = static_cast<double>(box_.x1 - box_.x0) * (box_.y1 - box_.y0);
  cell_px_ = std::max(1.0, std::sqrt(area / options.depth_rays));
  cells_per_px_ = static_cast<float>(1 / cell_px_);
  depth_step_ = static_cast<float>(kDepthStepInCells * cell_px_ / view_.camera.fx);
  cell_x0_ = static_cast<int>(box_.x0 / cell_px_);
  cell_y0_ = static_cast<int>(box_.y0 / cell_px_);
  const int width = static_cast<int>(std::ceil(box_.x1 / cell_px_)) - cell_x0_,
            height = static_cast<int>(std::ceil(box_.y1 / cell_px_)) - cell_y0_;
  depth_ = ImageF(width, height, 1, std::numeric_limits<float>::infinity());
  ray_face_ = ImageT<int>(width, height, 1, -1);
  rays_ = ImageT<Vector3d>((width + kRayStep - 1) / kRayStep + 1,
                           (height + kRayStep - 1) / kRayStep + 1, 1, Vector3d::Zero());
  for (int y = 0; y < rays_.height; ++y)
    for (int x = 0; x < rays_.width; ++x)
      *rays_.at(x, y) =
          rotation_.transpose() * view_.camera.Unproject(RayPixel(kRayStep * x, kRayStep * y));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const RayScene::Hit hit = scene.Cast(center_, RayInWorld(x, y));
      if (hit.face < 0) continue;
      *ray_face_.at(x, y) = hit.face;
      *depth_.at(x, y) = static_cast<float>(hit.distance);
    }
  MarkEdges(photograph, options);
}

Vector3d BakeView::RayInWorld(int x, int y) const {
  const int x0 = x / kRayStep, y0 = y / kRayStep;
  const double fx = static_cast<double>(x % kRayStep) / kRayStep,
               fy = static_cast<double>(y % kRayStep) / kRayStep;
  const Vector3d *above = rays_.at(x0, y0), *below = rays_.at(x0, y0 + 1);
  return (1 - fy) * ((1 - fx) * above[0] + fx * above[1]) +
         fy * ((1 - fx) * below[0] + fx * below[1]);
}

void BakeView::MarkEdges(const Photograph& photograph, const BakeViewOptions& options) {
  ImageF distance(depth_.width, depth_.height, 1, kFar);
  const auto depth_at = [&](int x, int y) {
    return x < 0 || y < 0 || x >= depth_.width || y >= depth_.height
               ? std::numeric_limits<float>::infinity()
               : *depth_.at(x, y);
  };
  for (int y = 0; y < depth_.height; ++y)
    for (int x = 0; x < depth_.width; ++x) {
      const float d = *depth_.at(x, y);
      bool edge = std::isinf(d) || !AllObject(photograph.mask, RayPixel(x, y).x(),
                                              RayPixel(x, y).y(), 0.5 * cell_px_);
      for (int k = 0; k < 4 && !edge; ++k)
        edge = !(std::abs(depth_at(x + (k == 0) - (k == 1), y + (k == 2) - (k == 3)) - d) <
                 depth_step_ * d);
      if (edge) *distance.at(x, y) = 0;
    }
  DistanceToZero(distance);
  trust_ = Image8(depth_.width, depth_.height, 1);
  for (std::size_t i = 0; i < trust_.data.size(); ++i) {
    // The first cell beyond an edge is half a cell away from it.
    const double beyond = ((distance.data[i] - 0.5) * cell_px_ - options.edge_guard_px) /
                          std::max(options.edge_feather_px, 1e-6);
    trust_.data[i] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(beyond, 0.0, 1.0)));
  }
}

void BakeView::Hide(const Image8& squares, double side_px) {
  for (int y = 0; y < trust_.height; ++y)
    for (int x = 0; x < trust_.width; ++x) {
      const Vector2d pixel = RayPixel(x, y);
      const int sx = std::clamp(static_cast<int>(pixel.x() / side_px), 0, squares.width - 1),
                sy = std::clamp(static_cast<int>(pixel.y() / side_px), 0, squares.height - 1);
      if (*squares.at(sx, sy)) *trust_.at(x, y) = 0;
    }
}

Sighting BakeView::See(const Vector3d& x_in_world) const {
  Sighting sighting;
  const Vector3d x = rotation_ * x_in_world + view_.camera_from_world.translation;
  if (x.z() <= 0 || depth_.empty()) return sighting;
  sighting.pixel = view_.camera.Project(x);
  sighting.depth = x.z();
  sighting.trust = TrustAt(sighting.pixel.cast<float>(), static_cast<float>(sighting.depth));
  return sighting;
}

template <class T>
ImageF BakeView::DetailOf(const ImageT<T>& fine, int level, const float* linear) const {
  constexpr int kBandLevels = 3;
  const int low = std::min(level + kBandLevels, SizeOf(scales_) - 1);
  const double size = 1 << (base_level_ + level);
  ImageF detail(fine.width, fine.height, 1, std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      const T* p = fine.at(x, y);
      if (2 * p[3] <= std::numeric_limits<T>::max()) continue;
      const Sample around = Bilinear(
          low, Vector2d(box_.x0 + (x + 0.5) * size, box_.y0 + (y + 0.5) * size).cast<float>());
      if (!(around.alpha > 0)) continue;
      const auto luma = [](float r, float g, float b) {
        return std::sqrt(0.299f * r + 0.587f * g + 0.114f * b);
      };
      *detail.at(x, y) = luma(linear[p[0]], linear[p[1]], linear[p[2]]) -
                         luma(around.color[0], around.color[1], around.color[2]);
    }
  return detail;
}

ImageF BakeView::Detail(int level) const {
  return deep_levels_.empty() ? DetailOf(levels_[level], level, kLinear.data())
                              : DetailOf(deep_levels_[level], level, deep_linear_);
}

float BakeView::RayLevel() const { return static_cast<float>(std::log2(cell_px_)); }

}  // namespace keypose::texture
