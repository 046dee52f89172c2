#include "composite/layer/table_shadow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"

namespace keypose::composite {
namespace {

constexpr int kLampRays = 24;
constexpr double kGolden = 2.399963229728653;  // [rad]
// The lamp's grid, over the figure's diagonal.
constexpr double kCell = 0.011, kMargin = 0.15, kFade = 0.1;
/// A lower lamp's shadow has no end on a table.
constexpr double kLowest = 0.09;  // [rad] of the lower edge of its disk
constexpr double kLongest = 6;

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
    : ground_(ground), strength_(strength), sky_(figure, ground) {
  const Eigen::Vector3d& to = strength.light.direction;
  const double rise = std::clamp(to.dot(ground.up), -1.0, 1.0);
  const Eigen::Vector3d flat = rise * ground.up - to;
  away_ = flat.norm() > 1e-6 ? flat.normalized() : ground.right;
  across_ = ground.up.cross(away_);
  // The figure lies within half a diagonal of the origin, and is not higher than one: its shadow
  // reaches so much farther.
  const double low = std::max(kLowest, std::asin(rise) - strength.light.radius_rad);
  const double thrown = std::min(kLongest, 1 / std::tan(low));
  const double spread = thrown * std::tan(strength.light.radius_rad);
  near_ = -(0.5 + kMargin) * ground.diagonal;
  half_width_ = (0.5 + kMargin + spread) * ground.diagonal;
  cell_ = kCell * ground.diagonal;
  columns_ = static_cast<int>(std::ceil((1 + 2 * kMargin + thrown) / kCell)) + 1;
  rows_ = static_cast<int>(std::ceil(2 * half_width_ / cell_)) + 1;
  lamp_.resize(static_cast<std::size_t>(rows_) * columns_);
  const std::vector<Eigen::Vector3d> rays = RaysTo(strength.light, kLampRays);
  const Eigen::Vector3d start =
      ground.origin - 1e-5 * ground.diagonal * ground.up + near_ * away_ - half_width_ * across_;
  ParallelFor(rows_, [&](std::int64_t j) {
    for (int i = 0; i < columns_; ++i) {
      const Eigen::Vector3d from =
          start + i * cell_ * away_ + static_cast<double>(j) * cell_ * across_;
      int hidden = 0;
      for (const Eigen::Vector3d& ray : rays)
        hidden += figure.Occluded(from, ray, 0, std::numeric_limits<double>::infinity());
      lamp_[static_cast<std::size_t>(j) * columns_ + i] = static_cast<float>(hidden) / kLampRays;
    }
  });
}

double TableShadow::HiddenLamp(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d local = point - ground_.origin;
  const double x = (local.dot(away_) - near_) / cell_,
               y = (local.dot(across_) + half_width_) / cell_;
  const double border = std::min(std::min(x, columns_ - 1 - x), std::min(y, rows_ - 1 - y));
  if (border <= 0) return 0;
  const int i = std::min(static_cast<int>(x), columns_ - 2),
            j = std::min(static_cast<int>(y), rows_ - 2);
  const double fx = x - i, fy = y - j;
  const float* at = lamp_.data() + static_cast<std::size_t>(j) * columns_ + i;
  const double hidden = (1 - fy) * ((1 - fx) * at[0] + fx * at[1]) +
                        fy * ((1 - fx) * at[columns_] + fx * at[columns_ + 1]);
  return hidden * std::min(1.0, border * kCell / kFade);
}

double TableShadow::Kept(const Eigen::Vector3d& point) const {
  const double sky = strength_.sky > 0 ? strength_.sky * sky_.Hidden(point) : 0,
               lamp = strength_.lamp > 0 ? strength_.lamp * HiddenLamp(point) : 0;
  return std::clamp(1 - sky - lamp, 0.0, 1.0);
}

}  // namespace keypose::composite
