#include "synth/photographs/light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

// number of computed lamp azimuths; others are interpolated, which also softens the light
constexpr int kTurns = 24;
constexpr int kSkyRays = 32;
constexpr double kSkyReach = 0.09;  // [m] clay farther away casts no sky shadow
constexpr double kOffset = 0.0004;  // [m] offset of ray origins from the surface
constexpr double kSkyFar = 1.0;     // [m]
constexpr int kGrid = 128;
constexpr double kTableBounce = 0.45;  // brightness of the table for directions below the horizon

Vector3d Towards(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

// Cosine-weighted directions around +z, evenly spread (a Fibonacci spiral).
std::array<Vector3d, kSkyRays> SkyDirections() {
  std::array<Vector3d, kSkyRays> directions;
  for (int i = 0; i < kSkyRays; ++i) {
    const double r2 = (i + 0.5) / kSkyRays, r = std::sqrt(r2), angle = 2.399963229728653 * i;
    directions[i] = Vector3d(r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r2));
  }
  return directions;
}

double SkyAt(const RayScene& scene, const Vector3d& origin, const Vector3d& normal,
             const std::array<Vector3d, kSkyRays>& directions) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal);
  double sum = 0;
  for (const Vector3d& direction : directions) {
    const Vector3d d = turn * direction;
    if (scene.Occluded(origin, d, 0, kSkyReach)) continue;
    const bool table = d[2] < 0 && origin[2] / -d[2] < kSkyReach;
    sum += table ? kTableBounce : 1;
  }
  return sum / kSkyRays;
}

}  // namespace

Vector3d LampDirection(double azimuth_rad, double elevation_rad) {
  return Towards(azimuth_rad, elevation_rad);
}

LightField::LightField(const Mesh& surface, const PointsX3& normals, const RayScene& scene,
                       double elevation_rad)
    : vertices_(surface.points.rows()),
      lamp_(static_cast<std::size_t>(kTurns * vertices_)),
      sky_(static_cast<std::size_t>(vertices_)) {
  const auto sky_directions = SkyDirections();
  const auto bake = [&](std::int64_t v) {
    const Vector3d normal = normals.row(v);
    const Vector3d origin = Vector3d(surface.points.row(v)) + kOffset * normal;
    sky_[v] = static_cast<float>(SkyAt(scene, origin, normal, sky_directions));
    for (int turn = 0; turn < kTurns; ++turn) {
      int seen = 0;
      for (const double side : {-1.0, 1.0}) {
        const Vector3d d =
            Towards(2 * kPi * turn / kTurns + 0.07 * side, elevation_rad + 0.09 * side);
        if (normal.dot(d) > 0 && !scene.Occluded(origin, d, 0, kSkyFar)) ++seen;
      }
      lamp_[turn * vertices_ + v] = static_cast<std::uint8_t>(seen == 2 ? 255 : 128 * seen);
    }
  };
  ParallelFor(vertices_, bake, 256);
}

std::vector<float> LightField::Lamp(double azimuth_rad) const {
  const double turns = azimuth_rad / (2 * kPi) * kTurns;
  const double whole = std::floor(turns);
  const float share = static_cast<float>(turns - whole);
  const int first = ((static_cast<int>(whole) % kTurns) + kTurns) % kTurns,
            second = (first + 1) % kTurns;
  std::vector<float> lamp(static_cast<std::size_t>(vertices_));
  for (std::int64_t v = 0; v < vertices_; ++v)
    lamp[v] =
        ((1 - share) * lamp_[first * vertices_ + v] + share * lamp_[second * vertices_ + v]) / 255;
  return lamp;
}

TableLight::TableLight(const RayScene& scene, double half_width)
    : scene_(&scene), half_width_(half_width), sky_(kGrid * kGrid) {
  const auto directions = SkyDirections();
  const auto bake = [&](std::int64_t i) {
    const double x = half_width_ * (2.0 * static_cast<double>(i % kGrid) / (kGrid - 1) - 1),
                 y = half_width_ * (2.0 * static_cast<double>(i / kGrid) / (kGrid - 1) - 1);
    sky_[i] = static_cast<float>(SkyAt(*scene_, {x, y, 1e-5}, Vector3d::UnitZ(), directions));
  };
  ParallelFor(kGrid * kGrid, bake, 256);
}

std::vector<float> TableLight::Lamp(double azimuth_rad, double elevation_rad) const {
  constexpr int kRays = 20;
  std::vector<float> grid(kGrid * kGrid);
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const double x = half_width_ * (2.0 * (i % kGrid) / (kGrid - 1) - 1),
                 y = half_width_ * (2.0 * (i / kGrid) / (kGrid - 1) - 1);
    int seen = 0;
    for (int k = 0; k < kRays; ++k) {
      const double r = std::sqrt((k + 0.5) / kRays),
                   angle = 2.399963229728653 * k + static_cast<double>(Hash(i) & 1023) * 0.006;
      const Vector3d d = Towards(azimuth_rad + 0.20 * r * std::cos(angle),
                                 elevation_rad + 0.13 * r * std::sin(angle));
      seen += !scene_->Occluded({x, y, 1e-5}, d, 0, kSkyFar);
    }
    grid[i] = static_cast<float>(seen) / kRays;
  }
  return grid;
}

double TableLight::At(const std::vector<float>& grid, double x, double y) const {
  const double gx = (x / half_width_ + 1) / 2 * (kGrid - 1),
               gy = (y / half_width_ + 1) / 2 * (kGrid - 1);
  if (!(gx >= 0 && gy >= 0 && gx < kGrid - 1 && gy < kGrid - 1)) return 1;
  const int ix = static_cast<int>(gx), iy = static_cast<int>(gy);
  const double fx = gx - ix, fy = gy - iy;
  const float* g = grid.data() + iy * kGrid + ix;
  const double value =
      (1 - fy) * ((1 - fx) * g[0] + fx * g[1]) + fy * ((1 - fx) * g[kGrid] + fx * g[kGrid + 1]);
  // Fades towards the grid's border, where long shadows leave the grid.
  const double rim = std::max(std::abs(x), std::abs(y)) / half_width_;
  return value + (1 - value) * std::clamp((rim - 0.85) / 0.15, 0.0, 1.0);
}

}  // namespace keypose::synth
