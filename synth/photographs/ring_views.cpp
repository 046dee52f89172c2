#include "synth/photographs/ring_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

Camera MakeCamera(const PhotographerOptions& options) {
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = options.focal_35mm / 36 * std::max(options.width, options.height);
  camera.cx = options.width / 2.0 + options.principal_shift_px;
  camera.cy = options.height / 2.0 + options.principal_shift_px;
  camera.k1 = options.k1;
  camera.k2 = options.k2;
  camera.p1 = options.p1;
  camera.p2 = options.p2;
  return camera;
}

/// Largest image coordinate of the points in a ring of cameras, as a share of the image's half
/// height or half width.
double Reach(const PointsX3& points, const Camera& camera, double elevation, const Vector3d& target,
             double distance) {
  constexpr int kAround = 24;
  double reach = 0;
  for (int k = 0; k < kAround; ++k) {
    const double azimuth = 2 * kPi * k / kAround;
    const Vector3d out(std::cos(elevation) * std::cos(azimuth),
                       std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const Rigid3 camera_from_world = LookAt(target + distance * out, target);
    for (Eigen::Index i = 0; i < points.rows(); i += 8) {
      const Eigen::Vector2d pixel = camera.Project(camera_from_world * Vector3d(points.row(i)));
      reach = std::max({reach, std::abs(pixel[0] - camera.cx) / (camera.width / 2.0),
                        std::abs(pixel[1] - camera.cy) / (camera.height / 2.0)});
    }
  }
  return reach;
}

/// Camera distance of a ring at which the points fill the wanted share of the image.
double FitDistance(const PointsX3& points, const Camera& camera, double elevation,
                   const Vector3d& target, double fill) {
  const double radius = (points.rowwise() - target.transpose()).rowwise().norm().maxCoeff();
  double distance = 2.5 * radius * camera.fx / std::min(camera.width, camera.height);
  for (int round = 0; round < 4; ++round)
    distance *= Reach(points, camera, elevation, target, distance) / fill;
  return distance;
}

/// Cameras of a figure that was moved on the table, in the figure's frame, where the cameras have
/// moved instead.
void Move(std::vector<RingView>& views, const Mishaps& mishaps) {
  const Rigid3 table_from_world{
      Eigen::Quaterniond(Eigen::AngleAxisd(mishaps.moved_rad, Vector3d::UnitZ())),
      Vector3d(mishaps.moved_m, 0, 0)};
  const int n = SizeOf(views);
  for (int i = FirstAfter(mishaps.moved_from, n); i < n; ++i) {
    views[i].view.camera_from_world = Compose(views[i].view.camera_from_world, table_from_world);
    views[i].azimuth_rad -= mishaps.moved_rad;
    views[i].table_from_world = table_from_world;
  }
}

}  // namespace

std::vector<RingView> PlaceCameras(const PointsX3& points, const PhotographerOptions& options) {
  const Camera camera = MakeCamera(options);
  const Vector3d target(0, 0, (points.col(2).minCoeff() + points.col(2).maxCoeff()) / 2);
  Random random(options.seed * 7919 + 11);
  const int rings = SizeOf(options.elevations_deg);
  std::vector<RingView> placed;
  for (int ring = 0; ring < rings; ++ring) {
    const int count = options.views / rings + (ring < options.views % rings ? 1 : 0);
    const double elevation = options.elevations_deg[ring] * kPi / 180;
    const double distance = FitDistance(points, camera, elevation, target, options.fill);
    // The tripod is moved between rings: the aim changes, with a slight tilt. Rings start half a
    // step apart, so that views interleave.
    const Vector3d aim =
        target + options.aim_jitter * distance * Vector3d(0, 0, random.Uniform(-1, 1));
    const double roll = 2 * options.aim_jitter * random.Uniform(-1, 1),
                 sideways = options.aim_jitter * distance * random.Uniform(-1, 1);
    for (int k = 0; k < count; ++k) {
      RingView view;
      view.ring = ring;
      view.azimuth_rad = -kPi / 2 + 2 * kPi * (k + 0.5 * (ring % 2)) / count +
                         options.azimuth_jitter_deg * kPi / 180 * random.Uniform(-1, 1);
      const Vector3d out(std::cos(view.azimuth_rad), std::sin(view.azimuth_rad), 0),
          side(-out[1], out[0], 0);
      const Vector3d eye =
          target + distance * (std::cos(elevation) * out + std::sin(elevation) * Vector3d::UnitZ());
      const Vector3d goal = aim + sideways * side;
      view.view.camera_from_world =
          LookAt(eye, goal, Eigen::AngleAxisd(roll, (goal - eye).normalized()) * Vector3d::UnitZ());
      view.view.camera = camera;
      char name[32];
      std::snprintf(name, sizeof name, "IMG_%04d.jpg", SizeOf(placed) + 1);
      view.view.name = name;
      placed.push_back(view);
    }
  }
  Move(placed, options.mishaps);
  return placed;
}

ImageF Backdrop(const PhotographerOptions& options) {
  ImageF backdrop(options.width, options.height, 3);
  const bool studio = options.background == "studio";
  const auto smooth = [](double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
  };
  const auto row = [&](std::int64_t y) {
    for (int x = 0; x < options.width; ++x) {
      const double u = (x + 0.5) / options.height, v = (y + 0.5) / options.height;
      Vector3d color(0.50, 0.495, 0.49);
      if (studio) {
        // A paper sweep: wall above, table below, an out-of-focus pattern of stains, and paper
        // grain.
        const double table = smooth((v - 0.42) / 0.30);
        color = (1 - table) * Vector3d(0.36, 0.37, 0.40) + table * Vector3d(0.55, 0.53, 0.51);
        const double stains = FractalNoise({3.1 * u, 3.1 * v, 0.5}, 3, 0.5, 77),
                     paper = GradientNoise({160 * u, 160 * v, 0.5}, 78);
        color *= 1 + 0.10 * stains + 0.012 * paper;
        // Two blurred panels on the wall.
        const double left =
            smooth((0.22 - std::abs(u - 0.16)) / 0.06) * smooth((0.13 - std::abs(v - 0.20)) / 0.05);
        const double right =
            smooth((0.10 - std::abs(u - 1.16)) / 0.05) * smooth((0.22 - std::abs(v - 0.22)) / 0.05);
        color += 0.13 * left * Vector3d(0.1, 0.15, 0.35) - 0.14 * right * Vector3d(0.5, 0.6, 0.7);
      }
      float* out = backdrop.at(x, static_cast<int>(y));
      for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(std::max(0.01, color[c]));
    }
  };
  ParallelFor(options.height, row, 16);
  return backdrop;
}

}  // namespace keypose::synth
