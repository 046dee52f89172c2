#include "deform/volume/volume_correction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/tuned.h"

namespace keypose {

namespace {

// No record of the data (docs/algorithms/interpolate.md); sensitivity:
// docs/results/sensitivity.md.
struct VolumeCorrectionTuning {
  KEYPOSE_TUNED(double, kMostReach, 0.25);  // of the diagonal: largest displacement of a vertex
};

using CubicTerms = std::array<double, 4>;

/// The root nearest to zero, by Newton's method from zero; NaN where it does not converge.
double RootNearZero(const CubicTerms& c) {
  double x = 0;
  for (int pass = 0; pass < 60; ++pass) {
    const double value = c[0] + x * (c[1] + x * (c[2] + x * c[3])),
                 slope = c[1] + x * (2 * c[2] + x * 3 * c[3]);
    const double step = value / slope;
    if (!std::isfinite(step)) return std::numeric_limits<double>::quiet_NaN();
    x -= step;
    if (std::abs(step) <= 1e-16 * std::abs(x)) return x;
  }
  const double value = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
  return std::abs(value) <= 1e-12 * (std::abs(c[0]) + std::abs(c[1] * x))
             ? x
             : std::numeric_limits<double>::quiet_NaN();
}

/// A part is closed and oriented when its sides are twice as many as its edges, and each edge
/// occurs once in each direction.
std::vector<char> ClosedParts(const PoissonSystem& system) {
  const FacesX3& faces = system.faces();
  std::vector<std::array<int, 3>> sides;  // low, high, +1 or -1
  sides.reserve(faces.size());
  std::vector<int> first(system.vertex_count() + 1, 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++first[std::min(faces(f, k), faces(f, (k + 1) % 3)) + 1];
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  sides.resize(faces.size());
  std::vector<int> at(first.begin(), first.end() - 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      sides[at[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), a < b ? 1 : -1};
    }
  std::vector<char> closed(system.part_count(), 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) closed[system.parts()[faces(f, 0)]] = 1;
  for (std::size_t i = 0; i + 1 < first.size(); ++i)
    for (int s = first[i]; s < first[i + 1]; ++s) {
      int forward = 0, backward = 0;
      for (int o = first[i]; o < first[i + 1]; ++o)
        if (sides[o][1] == sides[s][1]) ++(sides[o][2] > 0 ? forward : backward);
      if (forward != 1 || backward != 1) closed[system.parts()[i]] = 0;
    }
  return closed;
}

}  // namespace

VolumeCorrection::VolumeCorrection(const PoissonSystem& system)
    : system_(&system), closed_(ClosedParts(system)), origins_(system.part_count()) {
  for (int i = system.vertex_count() - 1; i >= 0; --i) origins_[system.parts()[i]] = i;
}

/// Parts' volumes along points + x * direction, as polynomials of x. Computed relative to a vertex
/// of each part, for accuracy far from the origin.
std::vector<std::array<double, 4>> VolumeCorrection::Polynomials(const PointsX3& points,
                                                                 const PointsX3* direction) const {
  const FacesX3& faces = system_->faces();
  const std::vector<int>& parts = system_->parts();
  std::vector<CubicTerms> sums(system_->part_count(), CubicTerms{});
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const int part = parts[faces(f, 0)];
    if (!closed_[part]) continue;
    CubicTerms& sum = sums[part];
    const Eigen::Vector3d o = points.row(origins_[part]),
                          a = points.row(faces(f, 0)).transpose() - o,
                          b = points.row(faces(f, 1)).transpose() - o,
                          c = points.row(faces(f, 2)).transpose() - o;
    const Eigen::Vector3d bc = b.cross(c);
    sum[0] += a.dot(bc);
    if (!direction) continue;
    const Eigen::Vector3d da = direction->row(faces(f, 0)), db = direction->row(faces(f, 1)),
                          dc = direction->row(faces(f, 2));
    const Eigen::Vector3d mixed = db.cross(c) + b.cross(dc), both = db.cross(dc);
    sum[1] += da.dot(bc) + a.dot(mixed);
    sum[2] += da.dot(mixed) + a.dot(both);
    sum[3] += da.dot(both);
  }
  for (CubicTerms& sum : sums)
    for (double& x : sum) x /= 6;
  return sums;
}

std::vector<double> VolumeCorrection::Volumes(const PointsX3& points) const {
  std::vector<double> volumes;
  for (const CubicTerms& c : Polynomials(points, nullptr)) volumes.push_back(c[0]);
  return volumes;
}

PointsX3 VolumeCorrection::Direction(const PointsX3& points) const {
  return Directions({points}).front();
}

std::vector<PointsX3> VolumeCorrection::Directions(const KeyRefs& shapes) const {
  const FacesX3& faces = system_->faces();
  const std::vector<int>& parts = system_->parts();
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(system_->vertex_count(), 3 * std::ssize(shapes));
  ParallelFor(std::ssize(shapes), [&](std::int64_t s) {
    const PointsX3& p = shapes[s];
    PointsX3 gradient = PointsX3::Zero(p.rows(), 3);
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      if (!closed_[parts[faces(f, 0)]]) continue;
      // Relative to the first corner: the same sum for a closed part, with smaller numbers.
      const Eigen::RowVector3d e1 = p.row(faces(f, 1)) - p.row(faces(f, 0)),
                               e2 = p.row(faces(f, 2)) - p.row(faces(f, 0));
      const Eigen::RowVector3d sixth = e1.cross(e2) / 6;
      for (int k = 0; k < 3; ++k) gradient.row(faces(f, k)) += sixth;
    }
    b.middleCols<3>(3 * s) = gradient;
  });
  b = system_->SolveScreened(b);
  std::vector<PointsX3> directions;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    PointsX3 z = b.middleCols<3>(3 * static_cast<Eigen::Index>(s));
    // The unit of z is arbitrary; with a largest entry of 1 the steps are lengths.
    const double largest = std::sqrt(z.rowwise().squaredNorm().maxCoeff());
    if (largest > 0) z /= largest;
    directions.push_back(std::move(z));
  }
  return directions;
}

VolumeCorrection::Result VolumeCorrection::Apply(PointsX3& points, PointsX3 direction,
                                                 const std::vector<double>& targets,
                                                 const std::vector<int>& held) const {
  Result result;
  const PointsX3 z = system_->WithoutRows(std::move(direction), held);
  std::vector<CubicTerms> cubics = Polynomials(points, &z);
  const std::vector<int>& parts = system_->parts();
  std::vector<double> longest(cubics.size(), 0), step(cubics.size(), 0);
  for (Eigen::Index i = 0; i < z.rows(); ++i)
    longest[parts[i]] = std::max(longest[parts[i]], z.row(i).norm());
  const double reach = VolumeCorrectionTuning::kMostReach * BoundingDiagonal(points);
  for (std::size_t p = 0; p < cubics.size(); ++p) {
    if (!closed_[p] || !std::isfinite(targets[p])) continue;
    const double x = StepToVolume(cubics[p], targets[p]);
    if (!(std::abs(x) * longest[p] <= reach)) {
      ++result.unreachable;
      continue;
    }
    step[p] = x;
    ++result.corrected;
    result.largest_move = std::max(result.largest_move, std::abs(x) * longest[p]);
  }
  for (Eigen::Index i = 0; i < z.rows(); ++i)
    if (step[parts[i]] != 0) points.row(i) += step[parts[i]] * z.row(i);
  return result;
}

double StepToVolume(std::array<double, 4> volume, double target) {
  volume[0] -= target;
  return volume[0] == 0 ? 0 : RootNearZero(volume);
}

std::vector<double> PathVolumes(const std::vector<double>& v0, const std::vector<double>& v1,
                                double t) {
  std::vector<double> path(v0.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t p = 0; p < v0.size(); ++p)
    if (v0[p] * v1[p] > 0)
      path[p] =
          std::copysign(std::pow(std::abs(v0[p]), 1 - t) * std::pow(std::abs(v1[p]), t), v0[p]);
  return path;
}

}  // namespace keypose
