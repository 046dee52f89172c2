#include "motion/reconstruct/kept_volume.h"

#include <algorithm>
#include <cmath>

#include "core/geometry.h"
#include "core/size_of.h"
#include "deform/volume/volume_correction.h"

namespace keypose::motion {

namespace {

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
  State state;
  Measure(rest, state);
  volume_ = state.volume;
  // The volume is a cubic of the step, of which a symmetric difference gives the square term.
  const double step = kProbe * diagonal_;
  const std::vector<double> outer = Volumes(rest + step * state.field),
                            inner = Volumes(rest - step * state.field);
  for (int p = 0; p < SizeOf(volume_); ++p)
    curvature_.push_back((outer[p] + inner[p] - 2 * volume_[p]) / (2 * step * step));
}

void KeptVolume::Measure(const PointsX3& pose, State& state) const {
  const FacesX3& faces = system_->faces();
  const std::vector<int>& parts = system_->parts();
  state.gradient.setZero(pose.rows(), 3);
  state.field.resize(pose.rows(), 3);
  state.volume.assign(closed_.size(), 0);
  state.slope.assign(closed_.size(), 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const int a = faces(f, 0), b = faces(f, 1), c = faces(f, 2);
    const Eigen::RowVector3d e1 = pose.row(b) - pose.row(a), e2 = pose.row(c) - pose.row(a);
    const Eigen::RowVector3d sixth = e1.cross(e2) / 6;
    state.gradient.row(a) += sixth;
    state.gradient.row(b) += sixth;
    state.gradient.row(c) += sixth;
  }
  // Relative to a point of the pose, for accuracy far from the origin.
  const Eigen::RowVector3d origin = pose.row(0);
  for (Eigen::Index i = 0; i < pose.rows(); ++i) {
    const Eigen::RowVector3d row = state.gradient.row(i);
    state.volume[parts[i]] += (pose.row(i) - origin).dot(row) / 3;
    const double length = row.norm();
    state.slope[parts[i]] += amount_[i] * length;
    state.field.row(i) = row * (length > 0 ? amount_[i] / length : 0.0);
  }
}

std::vector<double> KeptVolume::Volumes(const PointsX3& pose) const {
  const FacesX3& faces = system_->faces();
  const std::vector<int>& parts = system_->parts();
  std::vector<double> volume(closed_.size(), 0);
  const Eigen::RowVector3d origin = pose.row(0);
  // A run of faces of one part is summed in a register.
  for (Eigen::Index f = 0; f < faces.rows();) {
    const int part = parts[faces(f, 0)];
    double sum = 0;
    for (; f < faces.rows() && parts[faces(f, 0)] == part; ++f) {
      const Eigen::RowVector3d a = pose.row(faces(f, 0)) - origin,
                               e1 = pose.row(faces(f, 1)) - pose.row(faces(f, 0)),
                               e2 = pose.row(faces(f, 2)) - pose.row(faces(f, 0));
      sum += a.dot(e1.cross(e2));
    }
    volume[part] += sum / 6;
  }
  return volume;
}

double KeptVolume::StepFor(int part, double missing, double slope, double before) const {
  const double here = slope + 2 * curvature_[part] * before, first = missing / here;
  const double second = missing / (here + curvature_[part] * first);
  return std::abs(before + second) < kMostReach * diagonal_ ? second : 0.0;
}

}  // namespace keypose::motion
