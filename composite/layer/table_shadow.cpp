#include "composite/layer/table_shadow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace keypose::composite {
namespace {

constexpr int kSide = 192;  // points along the side of the lamp's grid
constexpr int kLampRays = 24;
constexpr double kGolden = 2.399963229728653;  // [rad]
/// The lamp's grid reaches so many of the ground's reach to each side, and fades at its border.
constexpr double kGridReach = 2.6, kInner = 0.85;

}  // namespace

std::vector<Eigen::Vector3d> RaysTo(const SoftLamp& lamp, int count) {
  const Eigen::Vector3d right = lamp.direction.unitOrthogonal(), up = lamp.direction.cross(right);
  std::vector<Eigen::Vector3d> rays;
  for (int i = 0; i < count; ++i) {
    const double r = std::tan(lamp.radius_rad) * std::sqrt((i + 0.5) / count), angle = kGolden * i;
    rays.push_back(
        (lamp.direction + r * (std::cos(angle) * right + std::sin(angle) * up)).normalized());
  }
  return rays;
}

TableShadow::TableShadow(const RayScene& figure, const Ground& ground,
                         const ShadowStrength& strength)
    : ground_(ground),
      strength_(strength),
      sky_(figure, ground),
      half_side_(kGridReach * ground.reach),
      lamp_(static_cast<std::size_t>(kSide) * kSide) {
  // A low lamp throws the shadow to the far side: the grid moves there.
  const Eigen::Vector3d& to = strength.light.direction;
  const double rise = std::max(0.2, to.dot(ground.up));
  const Eigen::Vector2d away(-to.dot(ground.right), -to.dot(ground.back));
  middle_ = std::min(1.5 * ground.reach, 0.5 * ground.diagonal / rise) * away;
  const std::vector<Eigen::Vector3d> rays = RaysTo(strength.light, kLampRays);
  const Eigen::Vector3d start = ground.origin - 1e-5 * ground.diagonal * ground.up;
  ParallelFor(kSide, [&](std::int64_t j) {
    for (int i = 0; i < kSide; ++i) {
      const double x = middle_.x() + half_side_ * (2.0 * i / (kSide - 1) - 1),
                   y = middle_.y() + half_side_ * (2.0 * static_cast<double>(j) / (kSide - 1) - 1);
      const Eigen::Vector3d from = start + x * ground.right + y * ground.back;
      int hidden = 0;
      for (const Eigen::Vector3d& ray : rays)
        hidden += figure.Occluded(from, ray, 0, std::numeric_limits<double>::infinity());
      lamp_[j * kSide + i] = static_cast<float>(hidden) / kLampRays;
    }
  });
}

double TableShadow::HiddenLamp(const Eigen::Vector3d& point) const {
  const Eigen::Vector2d local = ground_.Local(point).head<2>() - middle_;
  const double rim = local.cwiseAbs().maxCoeff() / half_side_;
  if (rim >= 1) return 0;
  const double x = (local.x() / half_side_ + 1) * 0.5 * (kSide - 1),
               y = (local.y() / half_side_ + 1) * 0.5 * (kSide - 1);
  const int i = std::min(static_cast<int>(x), kSide - 2),
            j = std::min(static_cast<int>(y), kSide - 2);
  const double fx = x - i, fy = y - j;
  const float* at = lamp_.data() + static_cast<std::size_t>(j) * kSide + i;
  const double hidden =
      (1 - fy) * ((1 - fx) * at[0] + fx * at[1]) + fy * ((1 - fx) * at[kSide] + fx * at[kSide + 1]);
  return hidden * std::clamp((1 - rim) / (1 - kInner), 0.0, 1.0);
}

double TableShadow::Kept(const Eigen::Vector3d& point) const {
  const double sky = strength_.sky > 0 ? strength_.sky * sky_.Hidden(point) : 0,
               lamp = strength_.lamp > 0 ? strength_.lamp * HiddenLamp(point) : 0;
  return std::clamp(1 - sky - lamp, 0.0, 1.0);
}

}  // namespace keypose::composite
