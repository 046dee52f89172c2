#include "views/film/ground_shadow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"

namespace keypose {
namespace {

/// Points along the side of each grid, and how many grids, each twice as large as the one before.
constexpr int kSide = 128, kGrids = 3;
/// Points of a grid in a square of kTile x kTile take kPerPoint directions each, all different.
constexpr int kTile = 4, kPerPoint = 16, kDirections = kTile * kTile * kPerPoint;
/// Width of the mean that is taken twice where the shadow is soft.
constexpr int kSoft = 5;
constexpr int kSharpSide = kSide + 2 * (kSoft - 1), kRawSide = kSharpSide + kTile - 1;
/// Each grid gives way to the next one from this share of its half side to its border.
constexpr double kInner = 0.7;

/// Sobol's second dimension in [0, 1).
double Sobol(std::uint32_t i) {
  std::uint32_t bits = 0;
  for (std::uint32_t v = 1u << 31; i != 0; i >>= 1, v ^= v >> 1)
    if (i & 1) bits ^= v;
  return bits * 0x1p-32;
}

double VanDerCorput(std::uint32_t i) {
  double result = 0, digit = 0.5;
  for (; i != 0; i >>= 1, digit /= 2)
    if (i & 1) result += digit;
  return result;
}

/// The unit square's point on the unit disk; equal areas stay equal.
Eigen::Vector2d OnDisk(double x, double y) {
  const double a = 2 * x - 1, b = 2 * y - 1;
  if (a == 0 && b == 0) return {0, 0};
  const bool wide = std::abs(a) > std::abs(b);
  const double r = wide ? a : b;
  const double angle = wide ? M_PI / 4 * (b / a) : M_PI / 2 - M_PI / 4 * (a / b);
  return {r * std::cos(angle), r * std::sin(angle)};
}

/// Directions in the frame of the ground, as dense as the cosine to its normal. Each consecutive
/// kPerPoint of them are spread evenly too.
std::array<Eigen::Vector3d, kDirections> Directions() {
  std::array<Eigen::Vector3d, kDirections> directions;
  constexpr double kCentre = 0.5 / kDirections;  // Sobol's points lie at the corners of their cells
  for (std::uint32_t i = 0; i < kDirections; ++i) {
    const Eigen::Vector2d p = OnDisk(VanDerCorput(i) + kCentre, Sobol(i) + kCentre);
    const double rest = std::max(0.0, 1 - p.squaredNorm());
    directions[i] = {p.x(), p.y(), std::sqrt(rest)};
  }
  return directions;
}

/// Mean over the `width` x `width` values from each one on.
std::vector<float> Means(const std::vector<float>& values, int side, int width) {
  const int out_side = side - width + 1;
  std::vector<float> across(static_cast<std::size_t>(side) * out_side);
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < out_side; ++i) {
      float sum = 0;
      for (int u = 0; u < width; ++u) sum += values[j * side + i + u];
      across[j * out_side + i] = sum;
    }
  std::vector<float> means(static_cast<std::size_t>(out_side) * out_side);
  for (int j = 0; j < out_side; ++j)
    for (int i = 0; i < out_side; ++i) {
      float sum = 0;
      for (int v = 0; v < width; ++v) sum += across[(j + v) * out_side + i];
      means[j * out_side + i] = sum / static_cast<float>(width * width);
    }
  return means;
}

/// The hidden share at the points of a grid, from what each found with its own directions. Where
/// little is hidden, what hides it is far away and the shadow soft: there a mean over more points
/// removes the grain without a loss.
std::vector<float> Smoothed(const std::vector<float>& raw) {
  std::vector<float> sharp = Means(raw, kRawSide, kTile);
  const std::vector<float> soft =
      Means(Means(sharp, kSharpSide, kSoft), kSharpSide - kSoft + 1, kSoft);
  std::vector<float> result(soft.size());
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const float at_point = sharp[(j + kSoft - 1) * kSharpSide + i + kSoft - 1];
      const float around = soft[j * kSide + i];
      const float t = std::clamp((around - 0.3f) / 0.3f, 0.0f, 1.0f);
      result[j * kSide + i] = around + t * (at_point - around);
    }
  return result;
}

}  // namespace

Eigen::Vector3d Ground::Local(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d way = point - origin;
  return {way.dot(right), way.dot(back), way.dot(up)};
}

Ground GroundUnder(const std::vector<Mesh>& frames, const Eigen::Vector3d& up) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const Mesh& frame : frames) {
    low = low.cwiseMin(frame.points.colwise().minCoeff().transpose());
    high = high.cwiseMax(frame.points.colwise().maxCoeff().transpose());
  }
  Ground ground;
  ground.up = up;
  ground.right = Eigen::Vector3d::UnitX();
  ground.back = up.cross(ground.right);
  const Eigen::Vector3d middle = 0.5 * (low + high), size = high - low;
  ground.origin = middle - (middle - low).dot(up) * up;
  const double width = std::max(std::abs(size.dot(ground.right)), std::abs(size.dot(ground.back)));
  ground.diagonal = size.norm() > 0 ? size.norm() : 1;
  // A tall and thin figure has a shadow that is wider than itself.
  ground.reach = std::max(0.5 * width, 0.2 * ground.diagonal);
  return ground;
}

GroundShadow::GroundShadow(const RayScene& figure, const Ground& ground) : ground_(ground) {
  const auto directions = Directions();
  Eigen::Matrix3d world_from_local;
  world_from_local << ground.right, ground.back, ground.up;
  // Rays start a little below the table, so that soles that lie exactly on it are hit.
  const Eigen::Vector3d start = ground.origin - 1e-5 * ground.diagonal * ground.up;
  for (int g = 0; g < kGrids; ++g) {
    Grid grid;
    grid.half_side = 1.15 * ground.reach * (1 << g);
    const double step = 2 * grid.half_side / (kSide - 1);
    std::vector<float> raw(static_cast<std::size_t>(kRawSide) * kRawSide);
    ParallelFor(kRawSide, [&](std::int64_t j) {
      for (int i = 0; i < kRawSide; ++i) {
        const double x = (i - 0.5 * (kRawSide - 1)) * step;
        const double y = (static_cast<double>(j) - 0.5 * (kRawSide - 1)) * step;
        const Eigen::Vector3d origin = start + x * ground.right + y * ground.back;
        const int first = kPerPoint * static_cast<int>(i % kTile + kTile * (j % kTile));
        int hidden = 0;
        for (int k = first; k < first + kPerPoint; ++k)
          hidden += figure.Occluded(origin, world_from_local * directions[k], 0,
                                    std::numeric_limits<double>::infinity());
        raw[j * kRawSide + i] = static_cast<float>(hidden) / kPerPoint;
      }
    });
    grid.hidden = Smoothed(raw);
    grids_.push_back(std::move(grid));
  }
}

double GroundShadow::Grid::At(double right, double back) const {
  const auto place = [&](double at) {
    return std::clamp((at / half_side + 1) * 0.5 * (kSide - 1), 0.0, kSide - 1.001);
  };
  const double x = place(right), y = place(back);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double fx = x - i, fy = y - j;
  const float* at = hidden.data() + static_cast<std::size_t>(j) * kSide + i;
  return (1 - fy) * ((1 - fx) * at[0] + fx * at[1]) +
         fy * ((1 - fx) * at[kSide] + fx * at[kSide + 1]);
}

double GroundShadow::Hidden(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d local = ground_.Local(point);
  const double radius = local.head<2>().norm();
  double result = 0, left = 1;
  for (const Grid& grid : grids_) {
    // A smooth step: 1 inside, 0 from the border on.
    const double t = std::clamp((1 - radius / grid.half_side) / (1 - kInner), 0.0, 1.0);
    const double weight = left * t * t * (3 - 2 * t);
    if (weight > 0) result += weight * grid.At(local.x(), local.y());
    left -= weight;
  }
  return result;
}

}  // namespace keypose
