#include "reconstruct/turntable/ring_picture.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/pictures/render.h"
#include "core/values/errors.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Color = Eigen::Matrix<std::uint8_t, 3, 1>;

constexpr int kSamples = 3;  // pixels drawn per pixel of the result, along each axis

const Color kGrey(150, 150, 150);

/// Colours that are also distinct for colour-blind people (Okabe & Ito).
Color RingColor(int ring) {
  static const Color kColors[] = {{0, 114, 178},   {213, 94, 0},  {0, 158, 115},
                                  {204, 121, 167}, {230, 159, 0}, {86, 180, 233}};
  return ring < 0 ? kGrey : kColors[ring % 6];
}

/// A square canvas of the world's x and y, or x and z.
class Canvas {
 public:
  Canvas(int size, double reach, double middle_up, bool from_above)
      : image_(size * kSamples, size * kSamples, 3, 255),
        reach_(reach),
        middle_up_(middle_up),
        from_above_(from_above) {}

  Vector2d Place(const Vector3d& x) const {
    const double up = from_above_ ? x.y() : x.z() - middle_up_, half = image_.width / 2.0;
    return {half + half * x.x() / reach_, half - half * up / reach_};
  }
  void Dot(const Vector2d& at, const Color& color, double radius) {
    const double r = radius * kSamples;
    for (int y = static_cast<int>(std::floor(at.y() - r)); y <= at.y() + r; ++y)
      for (int x = static_cast<int>(std::floor(at.x() - r)); x <= at.x() + r; ++x) {
        if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) continue;
        if ((Vector2d(x + 0.5, y + 0.5) - at).squaredNorm() <= r * r)
          std::copy_n(color.data(), 3, image_.at(x, y));
      }
  }
  void Line(const Vector2d& from, const Vector2d& to, const Color& color, double width) {
    const int steps = std::max(1, static_cast<int>((to - from).norm()));
    for (int k = 0; k <= steps; ++k) Dot(from + (to - from) * k / steps, color, width / 2);
  }
  Image8 Shown() const {
    Image8 shown(image_.width / kSamples, image_.height / kSamples, 3);
    for (int y = 0; y < shown.height; ++y)
      for (int x = 0; x < shown.width; ++x)
        for (int c = 0; c < 3; ++c) {
          int sum = 0;
          for (int dy = 0; dy < kSamples; ++dy)
            for (int dx = 0; dx < kSamples; ++dx)
              sum += image_.at(x * kSamples + dx, y * kSamples + dy)[c];
          shown.at(x, y)[c] = static_cast<std::uint8_t>(sum / (kSamples * kSamples));
        }
    return shown;
  }

 private:
  Image8 image_;
  double reach_, middle_up_;
  bool from_above_;
};

void DrawFrustum(Canvas& canvas, const View& view, double depth, const Color& color) {
  const Rigid3 world = view.camera_from_world.Inverse();
  const Vector2d eye = canvas.Place(world.translation);
  std::vector<Vector2d> corners;
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    const Vector3d ray((x * view.camera.width - view.camera.cx) / view.camera.fx,
                       (y * view.camera.height - view.camera.cy) / view.camera.fy, 1);
    corners.push_back(canvas.Place(world * Vector3d(depth * ray)));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    canvas.Line(eye, corners[k], color, 0.9);
    canvas.Line(corners[k], corners[(k + 1) % 4], color,
                k == 0 ? 2.2 : 0.9);  // marks the picture's upper edge
  }
  canvas.Dot(eye, color, 3);
}

/// Mean error of the points that each view observes; negative if it observes none.
std::vector<double> ViewErrors(const Scene& scene) {
  std::vector<double> sum(scene.views.size(), 0), count(scene.views.size(), 0);
  for (const SparsePoint& point : scene.points)
    for (const int v : point.views) {
      sum[v] += point.error_px;
      count[v] += 1;
    }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] = count[v] > 0 ? sum[v] / count[v] : -1;
  return sum;
}

}  // namespace

Image8 DrawCameras(const Scene& scene, const std::vector<int>& ring_of_view,
                   const CameraPictureOptions& options) {
  if (scene.views.empty() || ring_of_view.size() != scene.views.size())
    throw InputError("a picture of cameras needs views and a ring for each; got " +
                     std::to_string(scene.views.size()) + " and " +
                     std::to_string(ring_of_view.size()));
  double reach = 0, low = 1e300, high = -1e300, distance = 0;
  for (const View& view : scene.views) {
    const Vector3d center = view.Center();
    reach = std::max(reach, center.head<2>().norm());
    low = std::min(low, center.z());
    high = std::max(high, center.z());
    distance += center.norm() / static_cast<double>(scene.views.size());
  }
  low = std::min(low, 0.0);
  high = std::max(high, 0.0);
  reach = 1.12 * std::max({reach, (high - low) / 2, 1e-9});
  const std::vector<double> errors = ViewErrors(scene);
  const std::size_t step = std::max<std::size_t>(1, scene.points.size() / 20000);
  const auto error_color = [&](std::size_t v) {
    return errors[v] < 0 ? kGrey : MapColor(errors[v] / options.worst_px);
  };
  std::vector<Image8> parts;
  for (const bool by_error : {false, true})
    for (const bool from_above : {true, false}) {
      Canvas canvas(options.size_px, reach, (low + high) / 2, from_above);
      const Vector2d origin = canvas.Place(Vector3d::Zero());
      for (const Vector3d& axis :
           {Vector3d(0.15, 0, 0), Vector3d(0, 0.15, 0), Vector3d(0, 0, 0.15)})
        canvas.Line(origin, canvas.Place(reach * axis), Color(200, 200, 200), 1.5);
      for (std::size_t p = 0; p < scene.points.size(); p += step)
        canvas.Dot(canvas.Place(scene.points[p].position), scene.points[p].color, 0.7);
      for (std::size_t v = 0; v < scene.views.size(); ++v)
        DrawFrustum(canvas, scene.views[v], 0.09 * distance,
                    by_error ? error_color(v) : RingColor(ring_of_view[v]));
      parts.push_back(canvas.Shown());
    }
  return TileImages(parts, 2, 4, {225, 228, 232});
}

}  // namespace keypose::reconstruct
