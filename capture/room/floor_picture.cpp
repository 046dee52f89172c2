#include "capture/room/floor_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kDarkest = 0.4,
                 kBrightest = 1.2;  // of the plane's own light, in shadow and beside
constexpr double kPattern = 6;      // grey levels: standard deviation of a window with a pattern
constexpr double kSame = 0.8;       // correlation of windows of one pattern
constexpr double kSameColour = 7;   // grey levels, root mean square of three colours
constexpr int kReach = 2;           // of windows [px]

/// Pixels with a depth on the plane.
Image8 OnPlane(const Image8& image, const std::vector<DepthSample>& samples,
               const std::vector<SampleLabel>& labels, const Support& support, double thickness) {
  Image8 on(image.width, image.height, 1, 0);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (labels[k] != SampleLabel::kSupport || std::abs(support.Above(samples[k].point)) > thickness)
      continue;
    const int x = static_cast<int>(std::floor(samples[k].pixel.x())),
              y = static_cast<int>(std::floor(samples[k].pixel.y()));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (x + dx >= 0 && y + dy >= 0 && x + dx < on.width && y + dy < on.height)
          *on.at(x + dx, y + dy) = 255;
  }
  return on;
}

/// Sums over a window of both pictures, where the plane is known.
struct WindowSums {
  double count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  std::array<double, 3> colour_a{}, colour_b{};
};

bool IsKnown(const std::uint8_t* colour) { return colour[0] || colour[1] || colour[2]; }

std::optional<WindowSums> SumsAt(const Image8& image, const Image8& floor, int x, int y) {
  WindowSums sums;
  for (int dy = -kReach; dy <= kReach; ++dy)
    for (int dx = -kReach; dx <= kReach; ++dx) {
      const int px = x + dx, py = y + dy;
      if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
      const std::uint8_t *p = image.at(px, py), *q = floor.at(px, py);
      if (!IsKnown(q)) continue;
      const double a = (p[0] + p[1] + p[2]) / 3.0, b = (q[0] + q[1] + q[2]) / 3.0;
      sums.count += 1;
      sums.a += a;
      sums.b += b;
      sums.aa += a * a;
      sums.bb += b * b;
      sums.ab += a * b;
      for (std::size_t c = 0; c < 3; ++c) {
        sums.colour_a[c] += p[c];
        sums.colour_b[c] += q[c];
      }
    }
  if (sums.count < (2 * kReach + 1) * (2 * kReach + 1) / 2.0) return std::nullopt;
  return sums;
}

Likeness LikenessOf(const WindowSums& sums) {
  const double gain = sums.a / std::max(1.0, sums.b);
  if (gain < kDarkest || gain > kBrightest) return kNotFloor;
  double off = 0;
  for (std::size_t c = 0; c < 3; ++c)
    off += std::pow((sums.colour_a[c] - gain * sums.colour_b[c]) / sums.count, 2) / 3;
  if (std::sqrt(off) > kSameColour) return kNotFloor;
  const double n = sums.count;
  const double var_a = sums.aa / n - std::pow(sums.a / n, 2),
               var_b = sums.bb / n - std::pow(sums.b / n, 2),
               together = sums.ab / n - sums.a * sums.b / (n * n);
  const double expected = gain * gain * var_b;
  if (expected < kPattern * kPattern)
    return var_a < kPattern * kPattern ? kPerhapsFloor : kNotFloor;
  return together > kSame * std::sqrt(var_a * var_b) ? kSurelyFloor : kNotFloor;
}

}  // namespace

FloorPicture::FloorPicture(const std::vector<Image8>& images, const std::vector<View>& views,
                           const CoarseDepths& depths, const StandingFigure& figure,
                           const FloorPictureOptions& options)
    : support_(figure.support) {
  const double cell = options.cell * depths.distance;
  const int side = 2 * static_cast<int>(std::ceil(options.reach / options.cell)) + 1;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& point : figure.points)
    middle += point / static_cast<double>(figure.points.size());
  along_x_ = cell * support_.up.unitOrthogonal();
  along_y_ = support_.up.cross(along_x_);
  origin_ = middle - support_.Above(middle) * support_.up - (side / 2) * (along_x_ + along_y_);
  colours_ = Image8(side, side, 3, 0);
  known_ = Image8(side, side, 1, 0);
  std::vector<Image8> on(images.size());
  ParallelFor(std::ssize(images), [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    on[v] = OnPlane(images[v], depths.views[v], figure.samples[v], support_, 2 * cell);
  });
  ParallelFor(side, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < side; ++x) {
      const Vector3d point = origin_ + x * along_x_ + y * along_y_;
      std::array<std::vector<std::uint8_t>, 3> seen;
      for (std::size_t v = 0; v < views.size(); ++v) {
        if ((views[v].camera_from_world * point).z() <= 0) continue;
        const Vector2d p = views[v].Project(point);
        const int px = static_cast<int>(std::floor(p.x())),
                  py = static_cast<int>(std::floor(p.y()));
        if (px < 0 || py < 0 || px >= on[v].width || py >= on[v].height || !*on[v].at(px, py))
          continue;
        for (std::size_t c = 0; c < 3; ++c) seen[c].push_back(images[v].at(px, py)[c]);
      }
      if (SizeOf(seen[0]) < options.fewest) continue;
      *known_.at(x, y) = 255;
      for (std::size_t c = 0; c < 3; ++c)
        colours_.at(x, y)[c] = std::max<std::uint8_t>(1, UpperMedianInPlace(seen[c]));
    }
  });
}

FloorPicture::Place FloorPicture::PlaceOf(const View& view, double x, double y) const {
  const Vector3d ray =
      view.camera_from_world.rotation.conjugate() * view.camera.Unproject(Vector2d(x, y));
  const double down = support_.up.dot(ray);
  if (down >= -1e-3 * ray.norm()) return {};
  const Vector3d center = view.Center();
  const Vector3d at = center - support_.Above(center) / down * ray - origin_;
  return {at.dot(along_x_) / along_x_.squaredNorm(), at.dot(along_y_) / along_y_.squaredNorm(),
          true};
}

Image8 FloorPicture::SeenBy(const View& view) const {
  Image8 seen(view.camera.width, view.camera.height, 3, 0);
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      const Place place = PlaceOf(view, x + 0.5, y + 0.5);
      const double px = std::round(place.x), py = std::round(place.y);
      if (!place.known || px < 0 || py < 0 || px >= known_.width || py >= known_.height) continue;
      const auto cx = static_cast<int>(px), cy = static_cast<int>(py);
      if (*known_.at(cx, cy)) std::copy_n(colours_.at(cx, cy), 3, seen.at(x, y));
    }
  return seen;
}

Image8 LikeFloor(const Image8& image, const Image8& floor) {
  Image8 like(image.width, image.height, 1, 0);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (!IsKnown(floor.at(x, y))) continue;
      if (const auto sums = SumsAt(image, floor, x, y)) *like.at(x, y) = LikenessOf(*sums);
    }
  return like;
}

}  // namespace keypose::capture
