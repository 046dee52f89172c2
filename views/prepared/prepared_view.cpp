#include "views/prepared/prepared_view.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/statistics.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

// pixels of background around the mask, so that windows at its border have real samples
constexpr int kMargin = 8;

struct Box {
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;  // inclusive
  bool empty() const { return x1 < x0; }
};

Image8 BoxScaled(const Image8& image, int width, int height) {
  if (width == image.width && height == image.height) return image;
  const int channels = image.channels;
  ImageF rows(width, image.height, channels);
  const double sx = static_cast<double>(image.width) / width,
               sy = static_cast<double>(image.height) / height;
  for (int x = 0; x < width; ++x) {
    const double begin = x * sx, end = begin + sx;
    for (int y = 0; y < image.height; ++y)
      for (int c = 0; c < channels; ++c) {
        double sum = 0;
        for (int i = static_cast<int>(begin); i < end && i < image.width; ++i)
          sum += image.at(i, y)[c] * (std::min<double>(i + 1, end) - std::max<double>(i, begin));
        rows.at(x, y)[c] = static_cast<float>(sum / sx);
      }
  }
  Image8 out(width, height, channels);
  for (int y = 0; y < height; ++y) {
    const double begin = y * sy, end = begin + sy;
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) {
        double sum = 0;
        for (int i = static_cast<int>(begin); i < end && i < image.height; ++i)
          sum += rows.at(x, i)[c] * (std::min<double>(i + 1, end) - std::max<double>(i, begin));
        out.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(std::clamp(sum / sy, 0.0, 255.0)));
      }
  }
  return out;
}

// Photographs are first scaled with their distortion and then undistorted; `cx` etc. are in core's
// convention (centres at .5).
Camera ScaledCamera(const Camera& camera, int width, int height) {
  Camera scaled = camera;
  const double sx = static_cast<double>(width) / camera.width,
               sy = static_cast<double>(height) / camera.height;
  scaled.width = width;
  scaled.height = height;
  scaled.fx *= sx;
  scaled.cx *= sx;
  scaled.fy *= sy;
  scaled.cy *= sy;
  return scaled;
}

// Position of an undistorted pixel in the distorted image, both with centres at whole numbers.
Eigen::Vector2f Source(const Camera& camera, int x, int y) {
  const Eigen::Vector3d ray((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy,
                            1.0);
  const Eigen::Vector2d p = camera.Project(ray);
  return {static_cast<float>(p.x() - 0.5), static_cast<float>(p.y() - 0.5)};
}

float Bilinear(const Image8& image, float x, float y, int c) {
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
  const float fx = x - x0, fy = y - y0;
  const float top = image.at(x0, y0)[c] * (1 - fx) + image.at(x1, y0)[c] * fx;
  const float low = image.at(x0, y1)[c] * (1 - fx) + image.at(x1, y1)[c] * fx;
  return top * (1 - fy) + low * fy;
}

/// Where the undistorted picture shows more than the photograph, a mask that is cut by the
/// photograph's side goes on: what lies there is unknown, and not the end of the figure.
Image8 StraightMask(const Image8& mask, const Camera& camera) {
  const Eigen::Vector2f last(static_cast<float>(mask.width - 1),
                             static_cast<float>(mask.height - 1));
  Image8 out(mask.width, mask.height, 1);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      Eigen::Vector2f p = camera.distorted() ? Source(camera, x, y) : Eigen::Vector2f(x, y);
      p = p.cwiseMax(0).cwiseMin(last);
      if (Bilinear(mask, p.x(), p.y(), 0) > 127.5f) *out.at(x, y) = 255;
    }
  return out;
}

Box MaskBox(const Image8& mask) {
  Box box{mask.width, mask.height, -1, -1};
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.at(x, y)) {
        box.x0 = std::min(box.x0, x);
        box.x1 = std::max(box.x1, x);
        box.y0 = std::min(box.y0, y);
        box.y1 = std::max(box.y1, y);
      }
  if (box.empty()) return box;
  return {std::max(0, box.x0 - kMargin), std::max(0, box.y0 - kMargin),
          std::min(mask.width - 1, box.x1 + kMargin), std::min(mask.height - 1, box.y1 + kMargin)};
}

std::uint16_t Packed(float grey, bool inside) {
  const int value = static_cast<int>(std::clamp(grey, 0.0f, 255.0f) * (32767.0f / 255.0f) + 0.5f);
  return static_cast<std::uint16_t>(value << 1 | (inside ? 1 : 0));
}

void FillLevelZero(const Image8& image, const Image8& mask, const Camera& camera, const Box& box,
                   PreparedView* out) {
  const int width = box.x1 - box.x0 + 1, height = box.y1 - box.y0 + 1;
  PreparedView::Level level;
  level.camera = {
      width, height, camera.fx, camera.fy, camera.cx - 0.5 - box.x0, camera.cy - 0.5 - box.y0};
  level.grey = GreyMask(width, height, 1);
  out->color = Image8(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int gx = x + box.x0, gy = y + box.y0;
      Eigen::Vector2f p = camera.distorted() ? Source(camera, gx, gy) : Eigen::Vector2f(gx, gy);
      p = p.cwiseMax(0).cwiseMin(Eigen::Vector2f(image.width - 1, image.height - 1));
      float rgb[3];
      for (int c = 0; c < 3; ++c) {
        rgb[c] = Bilinear(image, p.x(), p.y(), c);
        out->color.at(x, y)[c] = static_cast<std::uint8_t>(rgb[c] + 0.5f);
      }
      const bool inside = *mask.at(gx, gy) != 0;
      out->masked_pixels += inside;
      *level.grey.at(x, y) = Packed(0.299f * rgb[0] + 0.587f * rgb[1] + 0.114f * rgb[2], inside);
    }
  out->levels.push_back(std::move(level));
}

// Running sums over `radius` places in both directions along `length` places with distance
// `stride`, for `lines` adjacent lines at once, so that memory is read in order.
void BoxBlur(const float* in, int length, int stride, int lines, int radius, float* out) {
  std::vector<double> sums(lines, 0.0);
  for (int i = -radius; i < length; ++i) {
    auto row = [&](int k) { return in + static_cast<std::ptrdiff_t>(k) * stride; };
    if (const int next = i + radius; next < length)
      for (int k = 0; k < lines; ++k) sums[k] += row(next)[k];
    if (const int last = i - radius - 1; last >= 0)
      for (int k = 0; k < lines; ++k) sums[k] -= row(last)[k];
    if (i >= 0)
      for (int k = 0; k < lines; ++k)
        out[static_cast<std::ptrdiff_t>(i) * stride + k] = static_cast<float>(sums[k]);
  }
}

// The light stays with the lamp while the figure turns, so smooth shading moves over the surface
// and wrong planes can agree. Subtracting the local mean removes slow changes and keeps texture.
// Areas without texture then have a low variance and are recognised as such.
PreparedView::Level WithoutShading(const PreparedView::Level& level) {
  constexpr int kRadius = 4, kRounds = 3;  // thrice a box of 9 is close to a Gaussian of 4.5 pixels
  const GreyMask& grey = level.grey;
  ImageF a(grey.width, grey.height, 2), b = a;
  for (std::size_t i = 0; i < grey.data.size(); ++i)
    if (InMask(grey.data[i])) {
      a.data[2 * i] = static_cast<float>(grey.data[i]) * kGreyScale;
      a.data[2 * i + 1] = 1;
    }
  for (int round = 0; round < kRounds; ++round) {
    for (int y = 0; y < grey.height; ++y)
      BoxBlur(a.at(0, y), grey.width, 2, 2, kRadius, b.at(0, y));
    BoxBlur(b.data.data(), grey.height, 2 * grey.width, 2 * grey.width, kRadius, a.data.data());
  }
  PreparedView::Level out = level;
  for (std::size_t i = 0; i < grey.data.size(); ++i) {
    if (!InMask(grey.data[i])) {
      out.grey.data[i] = Packed(128, false);
      continue;
    }
    out.grey.data[i] = Packed(
        128 + static_cast<float>(grey.data[i]) * kGreyScale - a.data[2 * i] / a.data[2 * i + 1],
        true);
  }
  return out;
}

PreparedView::Level Halved(const PreparedView::Level& fine) {
  PreparedView::Level level;
  const Pinhole& c = fine.camera;
  level.camera = {c.width / 2, c.height / 2,     c.fx / 2,
                  c.fy / 2,    (c.cx - 0.5) / 2, (c.cy - 0.5) / 2};
  level.grey = GreyMask(c.width / 2, c.height / 2, 1);
  for (int y = 0; y < c.height / 2; ++y)
    for (int x = 0; x < c.width / 2; ++x) {
      float sum = 0;
      int inside = 0;
      for (int k = 0; k < 4; ++k) {
        const std::uint16_t pixel = *fine.grey.at(2 * x + k % 2, 2 * y + k / 2);
        sum += static_cast<float>(pixel >> 1) * (255.0f / 32767.0f);
        inside += InMask(pixel);
      }
      *level.grey.at(x, y) = Packed(sum / 4, inside >= 2);
    }
  return level;
}

// Residual against its neighbours' plane, in blocks. Texture only adds to it, so a low quantile
// over the blocks is the noise.
double NoiseLevel(const GreyMask& grey) {
  constexpr int kBlock = 16;
  std::vector<double> blocks;
  for (int by = 1; by + kBlock < grey.height; by += kBlock)
    for (int bx = 1; bx + kBlock < grey.width; bx += kBlock) {
      double sum = 0;
      int count = 0;
      for (int y = by; y < by + kBlock; ++y)
        for (int x = bx; x < bx + kBlock; ++x) {
          if (!InMask(*grey.at(x, y))) continue;
          auto v = [&](int dx, int dy) {
            return static_cast<double>(*grey.at(x + dx, y + dy)) * kGreyScale;
          };
          // Immerkaer's mask annihilates planes; its response to white noise has 6 times the
          // standard deviation of the noise.
          const double r = v(-1, -1) + v(1, -1) + v(-1, 1) + v(1, 1) -
                           2 * (v(0, -1) + v(0, 1) + v(-1, 0) + v(1, 0)) + 4 * v(0, 0);
          sum += std::abs(r);
          ++count;
        }
      if (count > kBlock * kBlock / 2) blocks.push_back(sum / count * std::sqrt(M_PI / 2) / 6);
    }
  return QuantileAbove(std::move(blocks), 0.1);
}

}  // namespace

Eigen::Vector2d Pinhole::Project(const Eigen::Vector3d& x) const {
  return {fx * x.x() / x.z() + cx, fy * x.y() / x.z() + cy};
}

Eigen::Matrix3d Pinhole::K() const {
  Eigen::Matrix3d k;
  k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return k;
}

PreparedView PrepareView(const View& view, int scene_index, const Image8& image, const Image8& mask,
                         double scale, int levels) {
  auto size_of = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  if (image.width != view.camera.width || image.height != view.camera.height)
    throw InputError("dense: image '" + view.name + "' is " + size_of(image.width, image.height) +
                     ", but the model's camera is " +
                     size_of(view.camera.width, view.camera.height) +
                     "; run sfm again on these images");
  if (mask.width != image.width || mask.height != image.height)
    throw InputError("dense: the mask of image '" + view.name + "' is " +
                     size_of(mask.width, mask.height) + ", but the image is " +
                     size_of(image.width, image.height) + "; make the mask again (capture)");
  const int width = std::max(1, static_cast<int>(std::lround(image.width * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(image.height * scale)));
  const Camera camera = ScaledCamera(view.camera, width, height);
  PreparedView out;
  out.name = view.name;
  out.scene_index = scene_index;
  out.camera_from_world = view.camera_from_world;
  const Image8 straight_mask = StraightMask(BoxScaled(mask, width, height), camera);
  const Box box = MaskBox(straight_mask);
  const int least = 4 << (levels - 1);
  if (box.x1 - box.x0 + 1 < least || box.y1 - box.y0 + 1 < least) return out;
  FillLevelZero(BoxScaled(image, width, height), straight_mask, camera, box, &out);
  out.noise = NoiseLevel(out.levels[0].grey);
  while (SizeOf(out.levels) < levels) out.levels.push_back(Halved(out.levels.back()));
  for (PreparedView::Level& level : out.levels) level = WithoutShading(level);
  return out;
}

std::string NameList(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < 8; ++i) text += (i ? ", " : "") + names[i];
  return names.size() > 8 ? text + " and " + std::to_string(names.size() - 8) + " more" : text;
}

}  // namespace keypose
