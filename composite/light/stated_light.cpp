#include "composite/light/stated_light.h"

#include <algorithm>
#include <cmath>

#include "core/values/angles.h"

namespace keypose::composite {
namespace {

using Eigen::Vector3d;

constexpr double kFromSet = 0.2;  // of the sky's light, which table and set give back

/// Twice the clamped cosine to `lamp`, as far as degree 2.
/// Source: Ramamoorthi, Hanrahan, An efficient representation for irradiance environment maps,
/// 2001.
Harmonics LambertOf(const Vector3d& lamp) {
  const double x = lamp.x(), y = lamp.y(), z = lamp.z(), k = 5.0 / 16;
  Harmonics h;
  h << 0.5, x, y, z, 6 * k * x * y, 6 * k * y * z, 6 * k * x * z, 1.5 * k * (x * x - y * y),
      0.5 * k * (3 * z * z - 1);
  return h;
}

}  // namespace

Vector3d LampOf(const StatedLight& light, const View& view, const Vector3d& up) {
  const Eigen::Quaterniond world_from_camera = view.camera_from_world.rotation.conjugate();
  // A camera that looks straight down has the picture's upper side ahead.
  Vector3d ahead = world_from_camera * Vector3d::UnitZ();
  if (std::abs(ahead.dot(up)) > 0.999) ahead = world_from_camera * -Vector3d::UnitY();
  ahead = (ahead - ahead.dot(up) * up).normalized();
  const Vector3d right = ahead.cross(up);
  const double from = kDegree * light.from_deg, height = kDegree * light.height_deg;
  return std::cos(height) * (std::sin(from) * right - std::cos(from) * ahead) +
         std::sin(height) * up;
}

ShotLight LightOf(const StatedLight& light, bool plain, const View& view, const Vector3d& up) {
  Harmonics sum = light.lamp * LambertOf(LampOf(light, view, up));
  sum[0] += 1 - light.lamp;
  // Of an upright face 1: from above 2 / (1 + kFromSet), from below kFromSet of that.
  if (plain) sum.segment<3>(1) += (1 - light.lamp) * (1 - kFromSet) / (1 + kFromSet) * up;
  ShotLight shot;
  shot.harmonics = light.brightness * sum.replicate<1, 3>();
  return shot;
}

ShadowStrength ShadowOf(const StatedLight& light, const View& view, const Vector3d& up) {
  const Vector3d lamp = LampOf(light, view, up);
  const double of_sky = 1 - light.lamp, of_lamp = 2 * light.lamp * std::max(0.0, lamp.dot(up)),
               all = std::max(of_sky + of_lamp, 1e-9);
  ShadowStrength strength;
  strength.sky = (1 - kFromSet) * of_sky / all;
  strength.lamp = of_lamp / all;
  strength.light = {lamp, kDegree * light.size_deg / 2};
  return strength;
}

}  // namespace keypose::composite
