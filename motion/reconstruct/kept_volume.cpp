#include "motion/reconstruct/kept_volume.h"

#include <algorithm>
#include <cmath>

#include "core/geometry.h"
#include "core/size_of.h"
#include "deform/volume/volume_correction.h"

namespace keypose::motion {

namespace {

constexpr int kMostPasses = 4;
constexpr double kClose = 1e-5;      // of the volume
constexpr double kMostReach = 0.25;  // of the diagonal
constexpr double kProbe = 1e-3;      // of the diagonal: a step that tells the curvature at rest

}  // namespace

KeptVolume::KeptVolume(const PoissonSystem& system, const PointsX3& rest)
    : system_(&system), diagonal_(BoundingDiagonal(rest)) {
  const VolumeCorrection correction(system);
  closed_ = correction.closed_parts();
  any_closed_ = std::any_of(closed_.begin(), closed_.end(), [](char c) { return c != 0; });
  if (!any_closed_) return;
  amount_ = correction.Direction(rest)
                .cwiseProduct(VertexNormals(rest, system.faces()))
                .rowwise()
                .sum()
                .cwiseMax(0.0);
  const State state = StateOf(rest);
  volume_ = state.volume;
  // The volume is a cubic of the step, of which a symmetric difference gives the square term.
  const double step = kProbe * diagonal_;
  const std::vector<double> outer = StateOf(rest + step * state.field).volume,
                            inner = StateOf(rest - step * state.field).volume;
  for (int p = 0; p < SizeOf(volume_); ++p)
    curvature_.push_back((outer[p] + inner[p] - 2 * volume_[p]) / (2 * step * step));
}

KeptVolume::State KeptVolume::StateOf(const PointsX3& pose) const {
  const FacesX3& faces = system_->faces();
  const std::vector<int>& parts = system_->parts();
  PointsX3 gradient = PointsX3::Zero(pose.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const int a = faces(f, 0), b = faces(f, 1), c = faces(f, 2);
    const Eigen::RowVector3d e1 = pose.row(b) - pose.row(a), e2 = pose.row(c) - pose.row(a);
    const Eigen::RowVector3d sixth = e1.cross(e2) / 6;
    gradient.row(a) += sixth;
    gradient.row(b) += sixth;
    gradient.row(c) += sixth;
  }
  State state{std::vector<double>(closed_.size(), 0), std::vector<double>(closed_.size(), 0),
              std::move(gradient)};
  // Relative to a point of the pose, for accuracy far from the origin.
  const Eigen::RowVector3d origin = pose.row(0);
  for (Eigen::Index i = 0; i < pose.rows(); ++i) {
    auto row = state.field.row(i);
    state.volume[parts[i]] += (pose.row(i) - origin).dot(row) / 3;
    const double length = row.norm();
    state.slope[parts[i]] += amount_[i] * length;
    row *= length > 0 ? amount_[i] / length : 0.0;
  }
  return state;
}

KeptVolume::Result KeptVolume::Apply(PointsX3& pose) const {
  Result result;
  if (!any_closed_) return result;
  std::vector<double> step(closed_.size());
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const State state = StateOf(pose);
    bool again = false;
    for (int p = 0; p < SizeOf(step); ++p) {
      step[p] = 0;
      if (!closed_[p] || !(state.slope[p] > 0)) continue;
      const double missing = volume_[p] - state.volume[p], first = missing / state.slope[p];
      if (pass == 0) result.deviation = std::max(result.deviation, std::abs(missing / volume_[p]));
      const double second = missing / (state.slope[p] + curvature_[p] * first);
      if (!(std::abs(second) < kMostReach * diagonal_)) continue;
      step[p] = second;
      // What a third of the curvature being wrong would leave.
      again |= std::abs(curvature_[p]) * first * first / 3 > kClose * std::abs(volume_[p]);
    }
    for (Eigen::Index i = 0; i < pose.rows(); ++i)
      pose.row(i) += step[system_->parts()[i]] * state.field.row(i);
    // The field's largest entry is about 1.
    for (const double s : step) result.largest_move = std::max(result.largest_move, std::abs(s));
    if (!again) break;
  }
  return result;
}

}  // namespace keypose::motion
