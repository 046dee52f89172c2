#include "reconstruct/testing/printed_mat.h"

#include <algorithm>
#include <cmath>

#include "core/values/angles.h"

namespace keypose::reconstruct::testing {

using Eigen::Vector2d, Eigen::Vector3d;

Vector3d MatColour(const Vector2d& x, bool with_spots) {
  const double radius = x.norm(), angle = std::atan2(x.y(), x.x());
  if (radius > 1) return {70, 55, 40};
  const double tick = std::remainder(angle, 2 * kPi / 36) * radius;
  if (radius > 0.82 && radius < 0.92 && std::abs(tick) < 0.018) return {20, 20, 20};
  const double quarter = std::remainder(angle, kPi / 2);
  if ((Vector2d(std::cos(quarter), std::sin(quarter)) * radius - Vector2d(0.6, 0.1)).norm() < 0.1)
    return {20, 20, 20};
  if (with_spots) {
    const auto spot = [&](double at, double from, double size) {
      return (x - from * Vector2d(std::cos(at), std::sin(at))).norm() < size;
    };
    if (spot(0.9, 0.6, 0.09)) return {200, 40, 50};
    if (spot(2.7, 0.7, 0.07)) return {40, 60, 190};
    if (spot(4.4, 0.45, 0.08)) return {30, 140, 60};
  }
  return {225, 225, 220};
}

Image8 MatFrom(const View& view, bool with_spots, std::mt19937& random) {
  std::normal_distribution<double> noise(0, 3);
  Image8 picture(view.camera.width, view.camera.height, 3);
  const Vector3d center = view.Center();
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Vector3d ray = view.camera_from_world.rotation.conjugate() *
                           view.camera.Unproject(Vector2d(x + 0.5, y + 0.5));
      const Vector3d on = center - center.z() / ray.z() * ray;
      const Vector3d colour = MatColour(on.head<2>(), with_spots);
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] =
            static_cast<std::uint8_t>(std::clamp(colour[c] + noise(random), 0.0, 255.0));
    }
  return picture;
}

}  // namespace keypose::reconstruct::testing
