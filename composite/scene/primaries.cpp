#include "composite/scene/primaries.h"

#include <Eigen/LU>
#include <cmath>

namespace keypose::composite {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Primaries kRec709{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
const Primaries kAcesAp0{{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, {0.32168, 0.33767}};
const Primaries kAcesAp1{{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};

namespace {

constexpr double kRounding = 1e-4;

Vector3d XyzOf(const Vector2d& xy) { return {xy.x() / xy.y(), 1, (1 - xy.x() - xy.y()) / xy.y()}; }

/// For primaries, whose y may be 0 or less.
Vector3d DirectionOf(const Vector2d& xy) { return {xy.x(), xy.y(), 1 - xy.x() - xy.y()}; }

Matrix3d XyzFrom(const Primaries& p) {
  Matrix3d columns;
  columns << DirectionOf(p.red), DirectionOf(p.green), DirectionOf(p.blue);
  const Vector3d strengths = columns.inverse() * XyzOf(p.white);
  return columns * strengths.asDiagonal();
}

Matrix3d Adapted(const Vector2d& to, const Vector2d& from) {
  Matrix3d cones;
  cones << 0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296;
  const Vector3d factors = (cones * XyzOf(to)).cwiseQuotient(cones * XyzOf(from));
  return cones.inverse() * factors.asDiagonal() * cones;
}

Vector2d XyOf(const Vector3d& xyz) { return xyz.head<2>() / xyz.sum(); }

}  // namespace

Matrix3d LightFrom(const Primaries& to, const Primaries& from) {
  return XyzFrom(to).inverse() * Adapted(to.white, from.white) * XyzFrom(from);
}

Primaries PrimariesOf(const Matrix3d& light_from_rec709) {
  for (const Primaries& known : {kRec709, kAcesAp0, kAcesAp1})
    if ((LightFrom(known, kRec709) - light_from_rec709).cwiseAbs().maxCoeff() < kRounding)
      return known;
  const Matrix3d xyz = XyzFrom(kRec709) * light_from_rec709.inverse();
  return {XyOf(xyz.col(0)), XyOf(xyz.col(1)), XyOf(xyz.col(2)), XyOf(xyz * Vector3d::Ones())};
}

std::optional<Primaries> PrimariesOf(const std::array<float, 8>& c) {
  for (const float value : c)
    if (!std::isfinite(value)) return {};
  const Primaries p{{c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}};
  const Vector2d side = p.green - p.red, other = p.blue - p.red;
  const double area = side.x() * other.y() - side.y() * other.x();
  if (std::abs(area) < 1e-6 || !(p.white.y() > 1e-6)) return {};
  return p;
}

std::array<float, 8> ChromaticitiesOf(const Primaries& p) {
  std::array<float, 8> c{};
  int i = 0;
  for (const Vector2d& xy : {p.red, p.green, p.blue, p.white})
    for (const double value : xy) c[static_cast<std::size_t>(i++)] = static_cast<float>(value);
  return c;
}

bool SamePrimaries(const Primaries& a, const Primaries& b) {
  return (LightFrom(a, b) - Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRounding;
}

}  // namespace keypose::composite
