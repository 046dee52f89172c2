#include "synth/worlds/clay.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr double kBaseFillet = 0.0015;  // [m] radius of the rounded edge of the flat base

double LumpDistance(const Lump& lump, const Vector3d& x) {
  const Vector3d axis = lump.b - lump.a;
  const double length2 = axis.squaredNorm();
  const double h = length2 > 0 ? std::clamp((x - lump.a).dot(axis) / length2, 0.0, 1.0) : 0.0;
  return (x - lump.a - h * axis).norm() - (lump.ra + h * (lump.rb - lump.ra));
}

double SmoothMin(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width / 4;
}

double Ramp(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

constexpr double kTwoPi = 6.283185307179586;

// Sine ridges in patches. A low-frequency warp bends them into whorls.
struct Ridges {
  double patch = 0, phase = 0;       // share of the full height; phase of the sine [rad]
  Vector3d phase_gradient{0, 0, 0};  // [rad / m]
};

Ridges RidgesAt(const Clay& clay, const Vector3d& x) {
  Ridges ridges;
  ridges.patch = Ramp(GradientNoise(x / 0.016, clay.seed * 31 + 8), 0.05, 0.35);
  if (ridges.patch == 0) return ridges;
  constexpr double kWarpSize = 0.012, kWarp = 5;
  Vector3d warp_gradient;
  const double warp = kWarp * GradientNoise(x / kWarpSize, clay.seed * 31 + 9, &warp_gradient);
  const Vector3d direction(0.62, -0.35, 0.70);
  // The warp scales with the ridge spacing; otherwise the bends of wider ridges would cross.
  const double share = 0.0012 / clay.ridge_spacing;
  ridges.phase = kTwoPi * (x.dot(direction) / clay.ridge_spacing + share * warp);
  ridges.phase_gradient =
      kTwoPi * (direction / clay.ridge_spacing + share * kWarp / kWarpSize * warp_gradient);
  return ridges;
}

}  // namespace

double Clay::Distance(const Vector3d& x) const {
  double distance = std::numeric_limits<double>::infinity(), crisp_distance = distance;
  for (const Lump& lump : lumps) {
    const double d = LumpDistance(lump, x);
    if (lump.crisp) crisp_distance = std::min(crisp_distance, d);
    distance = std::isinf(distance) ? d : SmoothMin(distance, d, lump.blend);
  }
  if (std::abs(distance) < 0.01) {
    // The marks fade out towards a distance of 10 mm, so that the field is continuous, and near
    // crisp lumps, which are pressed in last.
    const double fade =
        Ramp(crisp_distance, 0, 0.003) * (1 - Ramp(std::abs(distance), 0.005, 0.01));
    if (fade > 0) distance += fade * dent_depth * FractalNoise(x / dent_size, 2, 0.5, seed);
  }
  if (flat_base) distance = -SmoothMin(-distance, x[2], kBaseFillet);
  return distance;
}

Vector3d Clay::Gradient(const Vector3d& x) const {
  constexpr double kStep = 1e-5;
  Vector3d gradient;
  for (int k = 0; k < 3; ++k) {
    const Vector3d step = kStep * Vector3d::Unit(k);
    gradient[k] = (Distance(x + step) - Distance(x - step)) / (2 * kStep);
  }
  return gradient;
}

int Clay::LumpAt(const Vector3d& x) const {
  int nearest = 0;
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < lumps.size(); ++i) {
    const double d = LumpDistance(lumps[i], x);
    if (d < distance) {
      distance = d;
      nearest = static_cast<int>(i);
    }
  }
  return nearest;
}

Vector3d Clay::Paint(const Vector3d& x, int lump) const {
  const Lump& clay = lumps[lump];
  Vector3d color = clay.color;
  const double strength = grain * (clay.crisp ? 0.15 : 1.0);
  const auto noise = [&](double wavelength, std::uint32_t stream) {
    return GradientNoise(x / (wavelength * grain_size), seed * 31 + stream);
  };
  const double coarse = noise(0.005, 2), fine = noise(0.0021, 3), hue = noise(0.009, 5);
  if (!clay.crisp)
    for (const Spot& spot : spots) {
      const double edge =
          (x - spot.center).norm() - spot.radius * (1 + 0.25 * std::min(1.0, grain) * hue);
      if (edge < 0.0004) color += (spot.color - color) * (1 - Ramp(edge, -0.0004, 0.0004));
    }
  // Kneaded clay: streaks of two shades, fine grain, and specks of dust.
  const double shade =
      0.16 * noise(0.014, 1) + 0.24 * coarse + 0.34 * fine + 0.26 * noise(0.0011, 4);
  const double speck = noise(0.0017, 6);
  const double specks = 0.55 * Ramp(speck, 0.42, 0.55) - 0.45 * Ramp(-speck, 0.42, 0.55);
  color *= std::clamp(1 + strength * (shade + specks), 0.15, 2.2);
  color += strength * 0.10 * hue *
           Vector3d(0.5, -0.1, -0.45).cwiseProduct(color + Vector3d::Constant(0.1));
  return color.cwiseMax(0.004).cwiseMin(0.95);
}

double Clay::RidgeHeight(const Vector3d& x, int lump) const {
  if (ridge_height == 0 || lumps[lump].crisp) return 0;
  const Ridges ridges = RidgesAt(*this, x);
  return ridges.patch * ridge_height * std::sin(ridges.phase);
}

Vector3d Clay::RidgeSlope(const Vector3d& x, int lump) const {
  if (ridge_height == 0 || lumps[lump].crisp) return Vector3d::Zero();
  const Ridges ridges = RidgesAt(*this, x);
  return ridges.patch * ridge_height * std::cos(ridges.phase) * ridges.phase_gradient;
}

void Clay::Bounds(Vector3d* low, Vector3d* high) const {
  *low = Vector3d::Constant(std::numeric_limits<double>::infinity());
  *high = -*low;
  for (const Lump& lump : lumps) {
    *low = low->cwiseMin(lump.a - Vector3d::Constant(lump.ra))
               .cwiseMin(lump.b - Vector3d::Constant(lump.rb));
    *high = high->cwiseMax(lump.a + Vector3d::Constant(lump.ra))
                .cwiseMax(lump.b + Vector3d::Constant(lump.rb));
  }
  const Vector3d margin = Vector3d::Constant(0.004 + 2 * dent_depth);
  *low -= margin;
  *high += margin;
  if (flat_base) (*low)[2] = std::max((*low)[2], -0.004);
}

}  // namespace keypose::synth
