// Photographs from rings around points, and what matches of them would be.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/values/angles.h"
#include "core/values/camera.h"
#include "core/values/size_of.h"
#include "reconstruct/turntable/ring_model.h"
#include "reconstruct/turntable/ring_start.h"

namespace keypose::reconstruct {

struct RingWorld {
  RingModel truth;
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<std::string> names;
  std::mt19937 random{7};

  double Gauss(double sigma) { return std::normal_distribution<double>(0, sigma)(random); }
  /// Whether a view sees a point of the closed body.
  bool Sees(std::size_t v, std::size_t p) const {
    const Rigid3 pose = truth.CameraFromTable(truth.views[v]);
    return normals[p].dot((pose.Inverse().translation - points[p]).normalized()) > 0.25;
  }
  Eigen::Vector2d Pixel(std::size_t v, std::size_t p, double noise) {
    return truth.camera.Project(truth.CameraFromTable(truth.views[v]) * points[p]) +
           Eigen::Vector2d(Gauss(noise), Gauss(noise));
  }
};

/// Rings of `count` cameras each at these elevations, 4 units from a body of half axes 0.5, 0.4,
/// 0.8 that is slightly off the axis.
inline RingWorld MakeWorld(const std::vector<double>& elevations_deg, int count, int points,
                           double slop_deg) {
  RingWorld world;
  Camera& camera = world.truth.camera;
  camera.width = 1200, camera.height = 900, camera.fx = camera.fy = 1800, camera.cx = 600,
  camera.cy = 450;
  for (std::size_t r = 0; r < elevations_deg.size(); ++r) {
    const double e = elevations_deg[r] * kDegree;
    const Eigen::Vector3d aim(0.05, -0.03, 0.1),
        eye =
            aim + (4 + 0.3 * static_cast<double>(r)) * Eigen::Vector3d(std::cos(e), 0, std::sin(e));
    const Eigen::Vector3d forward = (aim - eye).normalized(),
                          right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    rotation = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()) * rotation;
    world.truth.rings.push_back({Eigen::Quaterniond(rotation), -(rotation * eye)});
    world.truth.step_rad.push_back(2 * kPi / count);
    for (int k = 0; k < count; ++k) {
      const double start = 0.5 * static_cast<double>(r) * world.truth.step_rad[r];
      world.truth.views.push_back(
          {SizeOf(world.names), static_cast<int>(r), static_cast<double>(k),
           start + k * world.truth.step_rad[r] + world.Gauss(slop_deg * kDegree)});
      world.names.push_back("P" + std::to_string(1017 + world.names.size()) + ".jpg");
    }
  }
  for (int p = 0; p < points; ++p) {
    const Eigen::Vector3d d = Eigen::Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1))
                                  .normalized(),
                          axes(0.5, 0.4, 0.8);
    world.points.push_back(d.cwiseProduct(axes) + Eigen::Vector3d(0.1, 0, 0.05));
    world.normals.push_back(d.cwiseQuotient(axes).normalized());
  }
  return world;
}

/// Matches of all pairs of views up to 50 degrees apart, with `wrong` of them at random places.
inline std::vector<PairPoints> MakePairs(RingWorld& world, double noise, double wrong,
                                         std::size_t each) {
  std::vector<PairPoints> pairs;
  std::uniform_real_distribution<double> uniform(0, 1);
  for (std::size_t a = 0; a < world.truth.views.size(); ++a)
    for (std::size_t b = a + 1; b < world.truth.views.size(); ++b) {
      const Eigen::Quaterniond turn =
          SecondFromFirst(world.truth, world.truth.views[a], world.truth.views[b]).rotation;
      if ((turn * Eigen::Vector3d::UnitZ()).z() < std::cos(50 * kDegree)) continue;
      std::vector<Eigen::Vector4d> rows;
      for (std::size_t p = (a * 7 + b) % 3; p < world.points.size() && rows.size() < each; p += 3) {
        if (!world.Sees(a, p) || !world.Sees(b, p)) continue;
        rows.emplace_back();
        rows.back() << world.Pixel(a, p, noise), world.Pixel(b, p, noise);
        if (uniform(world.random) < wrong)
          rows.back().tail<2>() << 300 + 600 * uniform(world.random),
              200 + 500 * uniform(world.random);
      }
      PairPoints pair{world.truth.views[a].image, world.truth.views[b].image, {}};
      pair.xy.resize(std::ssize(rows), 4);
      for (std::size_t k = 0; k < rows.size(); ++k) pair.xy.row(k) = rows[k].transpose();
      if (!rows.empty()) pairs.push_back(std::move(pair));
    }
  return pairs;
}

inline PointsX3 Centers(const RingModel& model) {
  PointsX3 centers(std::ssize(model.views), 3);
  for (std::size_t v = 0; v < model.views.size(); ++v)
    centers.row(v) = model.CameraFromTable(model.views[v]).Inverse().translation.transpose();
  return centers;
}

inline PointsX3 Centers(const Scene& scene) {
  PointsX3 centers(std::ssize(scene.views), 3);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    centers.row(v) = scene.views[v].Center().transpose();
  return centers;
}

/// Largest distance of camera centres over the ring's radius, after a similarity.
inline double CenterError(const PointsX3& found, const PointsX3& truth) {
  return (Transformed(FitSimilarity(found, truth), found) - truth).rowwise().norm().maxCoeff() / 4;
}

}  // namespace keypose::reconstruct
