#include "composite/locating/clicks/clicked_place.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr int kFewest = 4, kFewestForFocal = 6;
constexpr double kOnOneLine = 1e-3;  // second over first spread of the places
constexpr double kDisagree = 0.03;   // root mean square error, of the picture's longer side

PointsX3 PlacesOf(const PointsX3& points, const std::vector<Click>& clicks) {
  PointsX3 places(SizeOf(clicks), 3);
  for (int i = 0; i < SizeOf(clicks); ++i) places.row(i) = PositionOf(clicks[i].point, points);
  return places;
}

void RequireSpread(const PointsX3& places) {
  const PointsX3 from_mean = places.rowwise() - places.colwise().mean();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(from_mean.transpose() * from_mean);
  const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  if (spread[1] <= kOnOneLine * spread[2])
    throw InputError(
        "locate: the clicked places of the mesh lie on one line, about which it can "
        "still turn; click another one beside that line");
}

Rigid3 SolvedPose(const Camera& camera, const PointsX3& places, const std::vector<Click>& clicks) {
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> rays;
  for (int i = 0; i < SizeOf(clicks); ++i) {
    const Eigen::Vector3d ray = camera.Unproject(clicks[i].pixel);
    objects.emplace_back(places(i, 0), places(i, 1), places(i, 2));
    rays.emplace_back(ray.x(), ray.y());
  }
  cv::Mat turn, shift, matrix;
  if (!cv::solvePnP(objects, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turn, shift, false,
                    cv::SOLVEPNP_SQPNP))
    throw InputError(
        "locate: no camera sees the clicked places at the clicked pixels; check the "
        "pairs");
  cv::Rodrigues(turn, matrix);
  Eigen::Matrix3d rotation;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rotation(r, c) = matrix.at<double>(r, c);
  return {Eigen::Quaterniond(rotation),
          {shift.at<double>(0), shift.at<double>(1), shift.at<double>(2)}};
}

/// Levenberg-Marquardt: a step that makes the error larger is taken back.
Placement Refined(Placement at, const PointsX3& points, const std::vector<Click>& clicks,
                  bool focal) {
  const PointsX3 places = PlacesOf(points, clicks);
  const Eigen::Vector3d center = places.colwise().mean();
  const double radius =
      std::sqrt((places.rowwise() - center.transpose()).rowwise().squaredNorm().mean());
  double damping = 1e-6, error = ClickError(at, points, clicks);
  for (int round = 0; round < 60; ++round) {
    NormalEquations equations(at, center, radius);
    for (int i = 0; i < SizeOf(clicks); ++i) {
      const Eigen::Vector3d x = places.row(i);
      const Eigen::Vector2d off = clicks[i].pixel - at.Project(x);
      equations.Add(x, Eigen::Vector2d::UnitX(), off.x(), 1);
      equations.Add(x, Eigen::Vector2d::UnitY(), off.y(), 1);
    }
    const Step step = equations.Solve(FreeUnknowns(focal, false), damping);
    const Placement next = equations.Moved(step);
    const double next_error = ClickError(next, points, clicks);
    if (next_error <= error) {
      at = next;
      error = next_error;
      damping = std::max(damping / 10, 1e-12);
      if (step.norm() < 1e-12) break;
    } else {
      damping = std::max(damping, 1e-9) * 10;
      if (damping > 1e6) break;
    }
  }
  return at;
}

void RequireAgreement(const Placement& at, const PointsX3& points,
                      const std::vector<Click>& clicks) {
  const double rms = ClickError(at, points, clicks);
  if (rms <= kDisagree * std::max(at.camera.width, at.camera.height)) return;
  // The worst is the one without which the others agree best.
  std::string worst = clicks[0].name;
  double least = 1e300;
  for (int i = 0; SizeOf(clicks) > kFewest && i < SizeOf(clicks); ++i) {
    std::vector<Click> others = clicks;
    others.erase(others.begin() + i);
    const Placement without =
        Refined({at.camera, SolvedPose(at.camera, PlacesOf(points, others), others)}, points,
                others, false);
    const double error = ClickError(without, points, others);
    if (error < least) {
      least = error;
      worst = clicks[i].name;
    }
  }
  throw InputError(fmt::format(
      "locate: the clicks do not agree: they lie {:.0f} pixels (root mean square) from where any "
      "camera would show those places; {}",
      rms,
      SizeOf(clicks) > kFewest ? "look at " + worst + " first"
                               : std::string("check each pair, and the focal length")));
}

}  // namespace

double ClickError(const Placement& at, const PointsX3& points, const std::vector<Click>& clicks) {
  double sum = 0;
  for (const Click& click : clicks) {
    const Eigen::Vector3d x = at.camera_from_mesh * PositionOf(click.point, points);
    if (x.z() <= 0) return 1e9;
    sum += (at.camera.Project(x) - click.pixel).squaredNorm();
  }
  return clicks.empty() ? 0 : std::sqrt(sum / SizeOf(clicks));
}

Placement PlaceByClicks(const Camera& camera, const PointsX3& points,
                        const std::vector<Click>& clicks, bool focal) {
  if (SizeOf(clicks) < kFewest)
    throw InputError(fmt::format(
        "locate: {} clicks do not fix a camera; click at least {} places, not on one line",
        clicks.size(), kFewest));
  const PointsX3 places = PlacesOf(points, clicks);
  RequireSpread(places);
  Placement at{camera, SolvedPose(camera, places, clicks)};
  at = Refined(at, points, clicks, focal && SizeOf(clicks) >= kFewestForFocal);
  RequireAgreement(at, points, clicks);
  return at;
}

}  // namespace keypose::composite
