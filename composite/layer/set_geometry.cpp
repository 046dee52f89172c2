#include "composite/layer/set_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace keypose::composite {
namespace {

using Eigen::Vector3d;

constexpr int kSetLampRays = 24, kSetSkyRays = 48;
constexpr double kSpiral = 2.399963229728653;  // [rad] golden angle
constexpr double kOffSurface = 1e-4;           // of the figure's diagonal
constexpr double kFarthest = 3;    // figure's diagonals from its middle: no shadow there
constexpr double kLeastSky = 0.2;  // of the sky's light that reaches any corner

/// Spread by the cosine around +z.
std::vector<Vector3d> SkyRays() {
  std::vector<Vector3d> rays;
  for (int i = 0; i < kSetSkyRays; ++i) {
    const double r2 = (i + 0.5) / kSetSkyRays, r = std::sqrt(r2), angle = kSpiral * i;
    rays.emplace_back(r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r2));
  }
  return rays;
}

Vector3d NormalOf(const SetGeometry& set, int face) {
  const auto corner = set.faces.row(face);
  const Vector3d a = set.points.row(corner[0]), b = set.points.row(corner[1]),
                 c = set.points.row(corner[2]);
  return (b - a).cross(c - a).normalized();
}

}  // namespace

SetShadow::SetShadow(const RayScene& figure, const SetGeometry& set, const Ground& table,
                     const ShadowStrength& strength)
    : figure_(figure),
      set_(set),
      table_(table),
      strength_(strength),
      lamp_(RaysTo(strength.light, kSetLampRays)),
      sky_(SkyRays()) {}

/// Whether the set hides a ray is only asked when the figure may count.
SetShadow::Light SetShadow::Rays(const Vector3d& from, const std::vector<Vector3d>& rays,
                                 const Eigen::Quaterniond& turn, const Vector3d& normal) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Light light;
  std::vector<std::uint8_t> taken(rays.size(), 0);
  bool any = false;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    taken[i] = figure_.Occluded(from, turn * rays[i], 0, kInfinity);
    any = any || taken[i];
  }
  if (!any) return {1, 0};
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Vector3d ray = turn * rays[i];
    if (ray.dot(normal) <= 0 || set_.scene.Occluded(from, ray, 0, kInfinity)) continue;
    light.seen += 1.0 / static_cast<double>(rays.size());
    light.hidden += taken[i] / static_cast<double>(rays.size());
  }
  return light;
}

double SetShadow::Kept(const Vector3d& place, int face, const Vector3d& eye) const {
  if ((place - table_.origin).norm() > kFarthest * table_.diagonal) return 1;
  Vector3d normal = NormalOf(set_, face);
  if (!normal.allFinite()) return 1;
  if (normal.dot(eye - place) < 0) normal = -normal;
  const Vector3d from = place + kOffSurface * table_.diagonal * normal;
  const Vector3d& to = strength_.light.direction;
  const Light lamp = Rays(from, lamp_, Eigen::Quaterniond::Identity(), normal),
              sky = Rays(from, sky_, Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal),
                         normal);
  if (lamp.hidden + sky.hidden <= 0) return 1;
  // On the table the lamp makes `strength_.lamp` of the light, at its own slant.
  const double slant = std::max(0.0, to.dot(normal)) / std::max(0.05, to.dot(table_.up));
  const double of_lamp = strength_.lamp * slant, of_sky = std::max(0.0, 1 - strength_.lamp);
  const double all = of_lamp * lamp.seen + of_sky * std::max(kLeastSky, sky.seen);
  if (all <= 0) return 1;
  const double lost = of_lamp * lamp.hidden + strength_.sky * sky.hidden;
  return std::clamp(1 - lost / all, 0.0, 1.0);
}

}  // namespace keypose::composite
