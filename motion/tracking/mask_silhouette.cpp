#include "motion/tracking/mask_silhouette.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

using Eigen::Vector2d;

constexpr int kMargin = 12;  // [px] of background around the mask

struct Box {
  int x0, y0, x1, y1;  // [x0, x1) x [y0, y1)
};

Box MaskBox(const Image8& mask, std::int64_t* pixels) {
  Box box{mask.width, mask.height, 0, 0};
  *pixels = 0;
  for (int y = 0; y < mask.height; ++y) {
    const std::uint8_t* row = mask.at(0, y);
    const auto count = std::count(row, row + mask.width, 1);
    if (count == 0) continue;
    *pixels += count;
    box.y0 = std::min(box.y0, y);
    box.y1 = y + 1;
    box.x0 = std::min(box.x0, static_cast<int>(std::find(row, row + mask.width, 1) - row));
    int last = mask.width;
    while (!row[last - 1]) --last;
    box.x1 = std::max(box.x1, last);
  }
  return {std::max(0, box.x0 - kMargin), std::max(0, box.y0 - kMargin),
          std::min(mask.width, box.x1 + kMargin), std::min(mask.height, box.y1 + kMargin)};
}

/// Around the pixels of a mask above 127, to eight columns.
Box LitBox(const Image8& mask) {
  constexpr std::uint64_t kHighBits = 0x8080808080808080;
  std::vector<std::uint64_t> columns(static_cast<std::size_t>(mask.width + 7) / 8, 0);
  Box box{mask.width, mask.height, 0, 0};
  for (int y = 0; y < mask.height; ++y) {
    std::uint64_t row = 0;
    for (int x = 0; x < mask.width; x += 8) {
      std::uint64_t eight = 0;
      if (x + 8 <= mask.width)
        std::memcpy(&eight, mask.at(x, y), 8);  // of known size: one instruction
      else
        std::memcpy(&eight, mask.at(x, y), mask.width - x);
      columns[x / 8] |= eight;
      row |= eight;
    }
    if (row & kHighBits) {
      box.y0 = std::min(box.y0, y);
      box.y1 = y + 1;
    }
  }
  for (int i = 0; i < SizeOf(columns); ++i)
    if (columns[i] & kHighBits) {
      box.x0 = std::min(box.x0, 8 * i);
      box.x1 = std::min(mask.width, 8 * i + 8);
    }
  return box;
}

// The mask field of views/hull works on prepared views; this one has nothing but its mask.
MaskField FieldOf(const Image8& reduced, const Box& box, const Pinhole& crop, const Rigid3& pose) {
  PreparedView view;
  view.camera_from_world = pose;
  view.levels.push_back({crop, GreyMask(crop.width, crop.height, 1)});
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x)
      *view.levels[0].grey.at(x, y) = *reduced.at(box.x0 + x, box.y0 + y);
  return MakeMaskField(view, 0);
}

void FindOutline(int wanted, Silhouette* silhouette) {
  const MaskField& field = silhouette->field;
  std::vector<Silhouette::Point> all;
  for (int y = 1; y + 1 < field.height; ++y)
    for (int x = 1; x + 1 < field.width; ++x) {
      const double d = field.At(x, y);
      if (d > 0 || d <= -1) continue;  // the last pixels inside
      Vector2d normal;
      silhouette->Distance(Vector2d(x, y), &normal);
      if (normal.squaredNorm() < 0.04 || silhouette->Cut(Vector2d(x, y))) continue;
      normal.normalize();
      all.push_back({Vector2d(x, y) - d * normal, normal});
    }
  const double step = std::max(1.0, SizeOf(all) / static_cast<double>(wanted));
  for (double at = 0; at < SizeOf(all); at += step)
    silhouette->outline.push_back(all[static_cast<std::size_t>(at)]);
  silhouette->outline_step = step;
}

}  // namespace

SilhouetteCamera::SilhouetteCamera(const View& view, double scale) : view_(view) {
  const Camera& camera = view.camera;
  pinhole_.width = std::max(1, static_cast<int>(std::lround(camera.width * scale)));
  pinhole_.height = std::max(1, static_cast<int>(std::lround(camera.height * scale)));
  const double sx = static_cast<double>(pinhole_.width) / camera.width,
               sy = static_cast<double>(pinhole_.height) / camera.height;
  pinhole_.fx = camera.fx * sx;
  pinhole_.fy = camera.fy * sy;
  pinhole_.cx = camera.cx * sx - 0.5;
  pinhole_.cy = camera.cy * sy - 0.5;
  rows_.resize(pinhole_.height);
  columns_.resize(pinhole_.width);
  source_.reserve(static_cast<std::size_t>(pinhole_.width) * pinhole_.height * 4);
  for (int y = 0; y < pinhole_.height; ++y)
    for (int x = 0; x < pinhole_.width; ++x)
      for (const auto& [dx, dy] : {std::pair{-.25, -.25}, {.25, -.25}, {-.25, .25}, {.25, .25}}) {
        const Vector2d p = camera.Project(pinhole_.Ray(x + dx, y + dy));
        const bool inside =
            p.x() >= 0 && p.y() >= 0 && p.x() < camera.width && p.y() < camera.height;
        const int px = static_cast<int>(p.x()), py = static_cast<int>(p.y());
        source_.push_back(inside ? py * camera.width + px : -1);
        if (!inside) continue;
        rows_[y].low = std::min(rows_[y].low, py);
        rows_[y].high = std::max(rows_[y].high, py);
        columns_[x].low = std::min(columns_[x].low, px);
        columns_[x].high = std::max(columns_[x].high, px);
      }
}

Image8 SilhouetteCamera::Reduced(const Image8& mask) const {
  if (mask.width != view_.camera.width || mask.height != view_.camera.height)
    throw InputError("track: the pictures of camera " + view_.name + " have " +
                     std::to_string(mask.width) + " x " + std::to_string(mask.height) +
                     " pixels, but it was calibrated with " + std::to_string(view_.camera.width) +
                     " x " + std::to_string(view_.camera.height) +
                     "; calibrate it at the size that it films with");
  Image8 reduced(pinhole_.width, pinhole_.height, 1);
  const Box lit = LitBox(mask);
  const auto meets = [](const Range& range, int low, int end) {
    return range.low < end && range.high >= low;
  };
  for (int y = 0; y < reduced.height; ++y) {
    if (!meets(rows_[y], lit.y0, lit.y1)) continue;
    const int* source = source_.data() + static_cast<std::size_t>(y) * reduced.width * 4;
    for (int x = 0; x < reduced.width; ++x, source += 4) {
      if (!meets(columns_[x], lit.x0, lit.x1)) continue;
      int inside = 0;
      for (int k = 0; k < 4; ++k) inside += source[k] >= 0 && mask.data[source[k]] > 127;
      *reduced.at(x, y) = inside >= 2;
    }
  }
  return reduced;
}

double Silhouette::Distance(const Vector2d& pixel, Vector2d* gradient) const {
  const double x = std::clamp(pixel.x(), 1.0, field.width - 2.001);
  const double y = std::clamp(pixel.y(), 1.0, field.height - 2.001);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double u = x - x0, v = y - y0;
  const float* row = field.distance.data() + static_cast<std::size_t>(y0) * field.width + x0;
  const float* below = row + field.width;
  const double inside =
      (1 - v) * ((1 - u) * row[0] + u * row[1]) + v * ((1 - u) * below[0] + u * below[1]);
  const Vector2d beyond = pixel - Vector2d(x, y);
  if (gradient) {
    // Central differences over two pixels are smoother than the cell's own slope.
    const float* above = row - field.width;
    const float* last = below + field.width;
    const auto dx = [&](const float* r) { return (1 - u) * (r[1] - r[-1]) + u * (r[2] - r[0]); };
    const double along_x = ((1 - v) * dx(row) + v * dx(below)) / 2;
    const double along_y =
        ((1 - v) * ((1 - u) * (below[0] - above[0]) + u * (below[1] - above[1])) +
         v * ((1 - u) * (last[0] - row[0]) + u * (last[1] - row[1]))) /
        2;
    *gradient = beyond.isZero() ? Vector2d(along_x, along_y) : Vector2d(beyond.normalized());
  }
  return inside + beyond.norm();
}

bool Silhouette::Cut(const Vector2d& pixel) const {
  constexpr double kSide = 4;
  return (field.edges[0] && pixel.x() < kSide) ||
         (field.edges[1] && pixel.x() > field.width - 1 - kSide) ||
         (field.edges[2] && pixel.y() < kSide) ||
         (field.edges[3] && pixel.y() > field.height - 1 - kSide);
}

Eigen::Vector3d Silhouette::Pull(const Eigen::Vector3d& x_in_world, const Vector2d& n) const {
  const Eigen::Vector3d x = camera_from_world * x_in_world;
  const double gx = n.x() * pinhole.fx / x.z(), gy = n.y() * pinhole.fy / x.z();
  const Eigen::Vector3d in_camera(gx, gy, -(gx * x.x() + gy * x.y()) / x.z());
  return camera_from_world.rotation.conjugate() * in_camera;
}

Silhouette MakeSilhouette(const SilhouetteCamera& camera, int index, const Image8& reduced,
                          int points) {
  Silhouette silhouette;
  silhouette.camera = index;
  silhouette.camera_from_world = camera.view().camera_from_world;
  silhouette.center = camera.view().Center();
  const Box box = MaskBox(reduced, &silhouette.pixels);
  silhouette.pinhole = camera.pinhole();
  if (silhouette.empty()) return silhouette;
  Pinhole& crop = silhouette.pinhole;
  crop.width = box.x1 - box.x0;
  crop.height = box.y1 - box.y0;
  crop.cx -= box.x0;
  crop.cy -= box.y0;
  silhouette.field = FieldOf(reduced, box, crop, silhouette.camera_from_world);
  FindOutline(points, &silhouette);
  return silhouette;
}

}  // namespace keypose::motion
