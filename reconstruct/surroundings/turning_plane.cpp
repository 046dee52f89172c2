#include "reconstruct/surroundings/turning_plane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <opencv2/calib3d.hpp>

#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

cv::Point2d PixelOf(const Vector3d& direction, const Camera& lens) {
  return {lens.fx * direction.x(), lens.fx * direction.y()};
}

bool Agree(const TurningPlane& a, const TurningPlane& b, const TurningPlaneOptions& options) {
  return (a.middle - b.middle).norm() < options.same_middle &&
         (a.normal - b.normal).norm() < options.same_normal;
}

}  // namespace

std::optional<TurningPlane> PlaneOfTurn(const Eigen::Matrix3d& homography,
                                        const TurningPlaneOptions& options) {
  const double scale = std::cbrt(homography.determinant());
  if (!std::isfinite(scale) || std::abs(scale) < 1e-12) return std::nullopt;
  const Eigen::EigenSolver<Eigen::Matrix3d> solver(homography / scale);
  if (solver.info() != Eigen::Success) return std::nullopt;
  int real = -1, complex = -1;
  for (int k = 0; k < 3; ++k) {
    const std::complex<double> value = solver.eigenvalues()(k);
    if (value.imag() == 0)
      real = k;
    else if (value.imag() > 0)
      complex = k;
  }
  if (real < 0 || complex < 0) return std::nullopt;
  const std::complex<double> turn = solver.eigenvalues()(complex);
  const double still = solver.eigenvalues()(real).real();
  if (still <= 0 || std::abs(std::arg(turn)) < options.least_turn ||
      std::abs(std::log(std::abs(turn) / still)) > options.unlike_turn)
    return std::nullopt;
  const Eigen::Vector3cd circular = solver.eigenvectors().col(complex);
  const std::complex<double> squared = (circular.transpose() * circular)(0);
  if (std::abs(squared) > options.unlike_turn * circular.squaredNorm()) return std::nullopt;
  TurningPlane plane;
  plane.middle = solver.eigenvectors().col(real).real().normalized();
  if (plane.middle.z() < 0) plane.middle = -plane.middle;
  const Vector3d a = circular.real(), b = circular.imag();
  plane.normal = a.cross(b).normalized();
  if (plane.normal.dot(plane.middle) > 0) plane.normal = -plane.normal;
  plane.pairs = 1;
  return plane;
}

std::optional<TurningPlane> CommonPlane(const std::vector<TurningPlane>& of_pairs,
                                        const TurningPlaneOptions& options) {
  TurningPlane common{};
  for (const TurningPlane& about : of_pairs) {
    TurningPlane mean{Vector3d::Zero(), Vector3d::Zero(), 0};
    for (const TurningPlane& other : of_pairs)
      if (Agree(about, other, options)) {
        mean.middle += other.middle;
        mean.normal += other.normal;
        ++mean.pairs;
      }
    if (mean.pairs > common.pairs) common = mean;
  }
  if (common.pairs < options.fewest_pairs) return std::nullopt;
  common.middle.normalize();
  common.normal.normalize();
  return common;
}

std::optional<FlatMatches> MatchesOnPlane(const Features& first, const Camera& first_lens,
                                          const Features& second, const Camera& second_lens,
                                          const PairMatches& pair,
                                          const TurningPlaneOptions& options) {
  if (SizeOf(pair.features) < options.fewest_matches) return std::nullopt;
  std::vector<Vector3d> from, to;
  std::vector<cv::Point2d> a, b;
  for (const auto& [i, j] : pair.features) {
    from.push_back(first_lens.Unproject(first.positions.row(i).transpose().cast<double>()));
    to.push_back(second_lens.Unproject(second.positions.row(j).transpose().cast<double>()));
    a.push_back(PixelOf(from.back(), first_lens));
    b.push_back(PixelOf(to.back(), second_lens));
  }
  constexpr int kTries = 3000;
  constexpr double kConfidence = 0.9999;
  cv::Mat inside;
  const cv::Mat1d found =
      cv::findHomography(a, b, cv::RANSAC, options.on_plane_px, inside, kTries, kConfidence);
  if (found.empty() || cv::countNonZero(inside) < options.fewest_matches) return std::nullopt;
  FlatMatches flat;
  for (int k = 0; k < SizeOf(from); ++k)
    if (inside.at<std::uint8_t>(k) != 0) {
      flat.first.push_back(from[static_cast<std::size_t>(k)]);
      flat.second.push_back(to[static_cast<std::size_t>(k)]);
    }
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) flat.homography(r, c) = found(r, c);
  const Vector3d by_first(first_lens.fx, first_lens.fx, 1),
      by_second(second_lens.fx, second_lens.fx, 1);
  flat.homography = by_second.cwiseInverse().asDiagonal() * flat.homography * by_first.asDiagonal();
  return flat;
}

std::optional<double> RadiusOnPlane(const TurningPlane& plane, const Vector3d& direction) {
  const double along = plane.normal.dot(plane.middle) / plane.normal.dot(direction);
  if (!(along > 0)) return std::nullopt;
  return (along * direction - plane.middle).norm();
}

Rigid3 CameraOver(const TurningPlane& plane, double distance) {
  Eigen::Matrix3d axes;
  axes.col(2) = plane.normal;
  axes.col(0) = (plane.normal * plane.normal.dot(plane.middle) - plane.middle).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes), distance * plane.middle};
}

}  // namespace keypose::reconstruct
