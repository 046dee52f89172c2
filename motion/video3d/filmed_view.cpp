#include "motion/video3d/filmed_view.h"

#include <algorithm>
#include <cmath>

#include "core/pictures/srgb.h"

namespace keypose::motion {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// Depth that changes from one pixel to the next by more than this many widths of a pixel on the
/// surface is an edge; a plane does so at under 10 degrees to the ray.
constexpr float kDepthStepInPixels = 6;
/// A point that is farther behind the depth buffer than this many widths of a pixel is hidden.
constexpr float kBehindInPixels = 4;

bool IsActor(const Image8& mask, int x, int y) { return mask.empty() || *mask.at(x, y) > 127; }

/// Whether two inverse depths of neighbours belong to different surfaces.
bool Differ(float a, float b, float per_pixel) {
  if (a == 0 || b == 0) return true;
  return std::abs(1 / a - 1 / b) > kDepthStepInPixels * per_pixel / std::min(a, b);
}

/// Catmull and Rom's weights of four neighbours.
void CubicWeights(float t, float* w) {
  w[0] = t * (-0.5f + t * (1 - 0.5f * t));
  w[1] = 1 + t * t * (-2.5f + 1.5f * t);
  w[2] = t * (0.5f + t * (2 - 1.5f * t));
  w[3] = t * t * (-0.5f + 0.5f * t);
}

}  // namespace

ImageF DistanceToEdges(const Image8& edges, float most) {
  ImageF d(edges.width, edges.height, 1, most);
  const float kDiagonal = std::sqrt(2.0f);
  const auto pass = [&](int x, int y, int way) {
    float& here = *d.at(x, y);
    if (*edges.at(x, y)) {
      here = 0;
      return;
    }
    const auto from = [&](int dx, int dy, float step) {
      const int px = x + dx * way, py = y + dy * way;
      if (px >= 0 && py >= 0 && px < d.width && py < d.height)
        here = std::min(here, *d.at(px, py) + step);
    };
    from(-1, 0, 1);
    from(0, -1, 1);
    from(-1, -1, kDiagonal);
    from(1, -1, kDiagonal);
  };
  for (int y = 0; y < d.height; ++y)
    for (int x = 0; x < d.width; ++x) pass(x, y, 1);
  for (int y = d.height - 1; y >= 0; --y)
    for (int x = d.width - 1; x >= 0; --x) pass(x, y, -1);
  return d;
}

FilmedView::FilmedView(const View& view, const Image8& picture, const Image8& mask,
                       const PointsX3& points, const FacesX3& faces,
                       const FilmedViewOptions& options)
    : view_(view), center_(view.Center()) {
  if (picture.empty()) return;
  depth_ = MakeDepthView(points, faces, view);
  if (depth_.box.empty()) return;
  CropPicture(picture);
  MeasureTrust(mask, options);
}

void FilmedView::CropPicture(const Image8& picture) {
  const PixelBox& box = depth_.box;
  color_ = ImageF(depth_.inverse.width, depth_.inverse.height, 3);
  for (int y = 0; y < color_.height; ++y) {
    const std::uint8_t* from = picture.at(box.x0, box.y0 + y);
    float* to = color_.at(0, y);
    for (int i = 0; i < 3 * color_.width; ++i) to[i] = LinearOf(from[i]);
  }
}

void FilmedView::MeasureTrust(const Image8& mask, const FilmedViewOptions& options) {
  const int w = color_.width, h = color_.height;
  const auto per_pixel = static_cast<float>(1 / std::min(view_.camera.fx, view_.camera.fy));
  Image8 edges(w, h, 1, 0);
  int inside = 0;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const float here = *depth_.inverse.at(x, y);
      const bool actor = IsActor(mask, depth_.box.x0 + x, depth_.box.y0 + y);
      pixels_ += here > 0;
      inside += here > 0 && actor;
      bool edge = here == 0 || !actor;
      if (x > 0) edge |= Differ(here, *depth_.inverse.at(x - 1, y), per_pixel);
      if (y > 0) edge |= Differ(here, *depth_.inverse.at(x, y - 1), per_pixel);
      *edges.at(x, y) = edge;
    }
  covered_ = pixels_ > 0 ? static_cast<double>(inside) / pixels_ : 1;
  const auto erosion = static_cast<float>(options.erosion_px),
             feather = static_cast<float>(std::max(options.feather_px, 1e-3));
  trust_ = DistanceToEdges(edges, erosion + feather);
  for (float& d : trust_.data) {
    const float t = std::clamp((d - erosion) / feather, 0.0f, 1.0f);
    d = t * t * (3 - 2 * t);
  }
}

Vector3f FilmedView::Color(const Vector2d& at) const {
  const double x = at.x() - depth_.box.x0 - 0.5, y = at.y() - depth_.box.y0 - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  float wx[4], wy[4];
  CubicWeights(static_cast<float>(x - x0), wx);
  CubicWeights(static_cast<float>(y - y0), wy);
  Vector3f sum = Vector3f::Zero();
  for (int j = 0; j < 4; ++j) {
    const int py = std::clamp(y0 - 1 + j, 0, color_.height - 1);
    for (int i = 0; i < 4; ++i) {
      const int px = std::clamp(x0 - 1 + i, 0, color_.width - 1);
      sum += wx[i] * wy[j] * Eigen::Map<const Vector3f>(color_.at(px, py));
    }
  }
  return sum.cwiseMax(0.0f).cwiseMin(1.0f);
}

Sighting FilmedView::See(const Vector3f& x_in_world, const Vector3f& normal) const {
  Sighting seen;
  if (sees_nothing()) return seen;
  const Vector3d world = x_in_world.cast<double>();
  const Vector3d to_camera = (center_ - world).normalized();
  seen.facing = std::max(0.0f, normal.dot(to_camera.cast<float>()));
  if (seen.facing <= 0) return seen;
  const Vector3d x = view_.camera_from_world * world;
  if (!(x.z() > 0)) return seen;
  const Vector2d at = view_.camera.Project(x);
  const int px = static_cast<int>(std::floor(at.x())) - depth_.box.x0,
            py = static_cast<int>(std::floor(at.y())) - depth_.box.y0;
  if (px < 0 || py < 0 || px >= trust_.width || py >= trust_.height) return seen;
  const float trust = *trust_.at(px, py), inverse = *depth_.inverse.at(px, py);
  if (trust <= 0 || inverse <= 0) return seen;
  const double per_pixel = 1 / std::min(view_.camera.fx, view_.camera.fy);
  if (x.z() - 1 / inverse > kBehindInPixels * per_pixel * x.z()) return seen;
  seen.trust = trust;
  seen.color = Color(at);
  return seen;
}

}  // namespace keypose::motion
