#include "synth/worlds/hand.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/numbers/parallel.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kSubpixels = 2;            // along each side of a pixel
const Vector3d kSkin(0.56, 0.30, 0.20);  // linear RGB

/// A round cone seen from the side: from a (radius ra) to b (radius rb) [px].
struct HandLimb {
  Vector2d a, b;
  double ra, rb;

  /// Height of its surface above the image plane [px]; 0 outside.
  double Height(const Vector2d& p) const {
    const Vector2d along = b - a;
    const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0),
                 r = ra + t * (rb - ra);
    const double beside = (p - a - t * along).squaredNorm();
    return beside < r * r ? std::sqrt(r * r - beside) : 0;
  }
};

Vector2d Turned(const Vector2d& v, double angle) { return Eigen::Rotation2Dd(angle) * v; }

/// The target of the fingers: a point of the figure, `share` of its width from the side that the
/// hand comes from.
Vector2d Goal(const Image8& mask, bool from_left, double height, double share) {
  int x0 = mask.width, x1 = -1, y0 = mask.height, y1 = -1;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.at(x, y) > 127) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
      }
  if (x1 < 0) return {mask.width / 2.0, mask.height / 2.0};
  const int y = static_cast<int>(y0 + height * (y1 - y0));
  int left = x1, right = x0;
  for (int x = x0; x <= x1; ++x)
    if (*mask.at(x, y) > 127) {
      left = std::min(left, x);
      right = std::max(right, x);
    }
  const double in = share * (right - left);
  return {from_left ? left + in : right - in, static_cast<double>(y)};
}

/// Forearm, palm, four fingers and a thumb, reaching for `goal` in the direction `reach`.
std::vector<HandLimb> LimbsOf(const Vector2d& goal, const Vector2d& reach, double unit,
                              double length) {
  const Vector2d across(-reach.y(), reach.x());
  const Vector2d knuckles = goal - 0.13 * unit * reach, wrist = knuckles - 0.15 * unit * reach;
  std::vector<HandLimb> limbs{{wrist - length * reach, wrist, 0.105 * unit, 0.062 * unit},
                              {wrist, knuckles, 0.066 * unit, 0.078 * unit}};
  for (int finger = 0; finger < 4; ++finger) {
    const double side = (finger - 1.5) * 0.046 * unit, bent = 0.02 * unit * std::abs(finger - 1.2);
    const Vector2d root = knuckles + side * across;
    limbs.push_back({root, root + (0.13 * unit - bent) * Turned(reach, 0.09 * (finger - 1.5)),
                     0.026 * unit, 0.020 * unit});
  }
  const Vector2d thumb = wrist + 0.05 * unit * reach + 0.06 * unit * across;
  limbs.push_back({thumb, thumb + 0.12 * unit * Turned(reach, 0.6), 0.028 * unit, 0.022 * unit});
  return limbs;
}

/// Skin colour at a point; alpha is 0 outside the hand.
Eigen::Vector4d SkinAt(const std::vector<HandLimb>& limbs, const Vector2d& p, double unit,
                       std::uint32_t seed) {
  const auto height = [&](const Vector2d& at) {
    double most = 0;
    for (const HandLimb& limb : limbs) most = std::max(most, limb.Height(at));
    return most;
  };
  const double here = height(p);
  if (here <= 0) return Eigen::Vector4d::Zero();
  constexpr double kStep = 0.5;
  const double dx = (height(p + Vector2d(kStep, 0)) - height(p - Vector2d(kStep, 0))) / (2 * kStep);
  const double dy = (height(p + Vector2d(0, kStep)) - height(p - Vector2d(0, kStep))) / (2 * kStep);
  const Vector3d normal = Vector3d(-dx, -dy, 1).normalized(),
                 lamp = Vector3d(-0.5, -0.65, 0.57).normalized();
  const double light = 0.42 + 0.75 * std::max(0.0, normal.dot(lamp));
  const double grain =
      0.06 * FractalNoise({60 * p.x() / unit, 60 * p.y() / unit, 0.5}, 3, 0.6, seed);
  const Vector3d color = light * (1 + grain) * kSkin;
  return {color[0], color[1], color[2], 1};
}

/// Paints limbs over a picture.
/// @param color_at  colour and coverage at a point
template <class ColorAt>
void PaintOver(ImageF& linear, Image8& mask, const ColorAt& color_at) {
  const auto row = [&](std::int64_t line) {
    const int y = static_cast<int>(line);
    for (int x = 0; x < linear.width; ++x) {
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      for (int j = 0; j < kSubpixels; ++j)
        for (int i = 0; i < kSubpixels; ++i)
          sum += color_at(Vector2d(x + (i + 0.5) / kSubpixels, y + (j + 0.5) / kSubpixels));
      const double covered = sum[3] / (kSubpixels * kSubpixels);
      if (covered <= 0) continue;
      float* pixel = linear.at(x, y);
      for (int c = 0; c < 3; ++c)
        pixel[c] =
            static_cast<float>((1 - covered) * pixel[c] + sum[c] / (kSubpixels * kSubpixels));
      if (covered >= 0.5) *mask.at(x, y) = 0;
    }
  };
  ParallelFor(linear.height, row, 16);
}

}  // namespace

void HoldHand(ImageF& linear, Image8& mask, std::uint64_t seed) {
  Random random(seed * 131 + 29);
  const bool from_left = random.Uniform() < 0.5;
  const double unit = linear.height, height = random.Uniform(0.35, 0.65),
               share = random.Uniform(0.25, 0.45);
  const Vector2d goal = Goal(mask, from_left, height, share);
  const Vector2d reach = Turned(Vector2d(from_left ? 1 : -1, 0), random.Uniform(-0.35, 0.35));
  const std::vector<HandLimb> limbs =
      LimbsOf(goal, reach, unit, std::hypot(linear.width, linear.height));
  PaintOver(linear, mask, [&](const Vector2d& p) {
    return SkinAt(limbs, p, unit, static_cast<std::uint32_t>(seed));
  });
}

void HoldTool(ImageF& linear, Image8& mask, std::uint64_t seed) {
  Random random(seed * 137 + 31);
  const Vector3d wood(0.30, 0.17, 0.07), steel(0.36, 0.38, 0.42);
  const bool from_left = random.Uniform() < 0.5;
  const double unit = linear.height, height = random.Uniform(0.3, 0.7),
               share = random.Uniform(0.5, 0.8), radius = random.Uniform(0.02, 0.03) * unit;
  const Vector2d goal = Goal(mask, from_left, height, share);
  const Vector2d reach = Turned(Vector2d(from_left ? 1 : -1, 0), random.Uniform(-0.5, 0.5));
  const Vector2d neck = goal - 0.14 * unit * reach;
  const double length = std::hypot(linear.width, linear.height);
  const HandLimb tip{neck, goal, 0.7 * radius, 0.35 * radius},
      handle{neck - length * reach, neck, radius, radius};
  PaintOver(linear, mask, [&](const Vector2d& p) -> Eigen::Vector4d {
    const double of_handle = handle.Height(p), of_tip = tip.Height(p);
    if (of_handle <= 0 && of_tip <= 0) return Eigen::Vector4d::Zero();
    const bool is_handle = of_handle > of_tip;
    const double round = is_handle ? of_handle / radius : of_tip / (0.7 * radius);
    const Vector3d color = (0.45 + 0.6 * round) * (is_handle ? wood : steel);
    return {color[0], color[1], color[2], 1};
  });
}

void HoldThumb(ImageF& linear, std::uint64_t seed) {
  Random random(seed * 139 + 37);
  const double unit = linear.height, far = std::hypot(linear.width, linear.height);
  const int side = static_cast<int>(random.Uniform() * 6) % 6;  // corners, then left, right
  const Vector2d starts[] = {{0, 0},          {1.0 * linear.width, 0},
                             {0, unit},       {1.0 * linear.width, unit},
                             {0, 0.5 * unit}, {1.0 * linear.width, 0.5 * unit}};
  const Vector2d start = starts[side], middle(0.5 * linear.width, 0.5 * unit);
  const Vector2d reach = Turned((middle - start).normalized(), random.Uniform(-0.2, 0.2));
  const double radius = random.Uniform(0.15, 0.25) * unit, soft = 0.05 * unit;
  const Vector2d tip = start + random.Uniform(0.2, 0.45) * unit * reach;
  const Vector2d round = tip - radius * reach, away = start - far * reach;
  Image8 nothing(linear.width, linear.height, 1, 0);
  PaintOver(linear, nothing, [&](const Vector2d& p) -> Eigen::Vector4d {
    const Vector2d along = round - away;
    const double t = std::clamp((p - away).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const double inside = (radius - (p - away - t * along).norm()) / soft;
    const double s = std::clamp(0.5 + 0.5 * inside, 0.0, 1.0), covered = s * s * (3 - 2 * s);
    const Vector3d color = covered * (0.5 + 0.2 * std::clamp(0.2 * inside, 0.0, 1.0)) * kSkin;
    return {color[0], color[1], color[2], covered};
  });
}

}  // namespace keypose::synth
