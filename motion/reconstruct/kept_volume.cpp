#include "motion/reconstruct/kept_volume.h"

#include <algorithm>
#include <cmath>

#include "core/geometry.h"
#include "core/size_of.h"
#include "deform/solvers/lanes.h"
#include "deform/volume/volume_correction.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::motion {

namespace {

constexpr double kMostReach = 0.25;  // of the diagonal
constexpr double kProbe = 1e-3;      // of the diagonal: a step that tells the curvature at rest

/// Some faces of a pose.
struct VolumeJob {
  const double* points;
  int last;  // vertex
  const int* faces;
  std::ptrdiff_t begin, end;
};

VolumeJob JobOf(const PointsX3& pose, const FacesX3& faces) {
  return {pose.data(), static_cast<int>(pose.rows()) - 1, faces.data(), 0, faces.rows()};
}

}  // namespace

namespace plain {
using namespace keypose::plain;
#include "motion/reconstruct/volume_sums.inc"
}  // namespace plain
KEYPOSE_FUSED_BEGIN
namespace fused {
using namespace keypose::fused;
#include "motion/reconstruct/volume_sums.inc"
}  // namespace fused
KEYPOSE_FUSED_END

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
  const std::vector<int>& parts = system_->parts();
  state.gradient.setZero(pose.rows(), 4);
  state.field.resize(pose.rows(), 3);
  state.volume.assign(closed_.size(), 0);
  state.slope.assign(closed_.size(), 0);
  const VolumeJob job = JobOf(pose, system_->faces());
  HasFused() ? fused::AddGradients(job, state.gradient.data())
             : plain::AddGradients(job, state.gradient.data());
  // Relative to a point of the pose, for accuracy far from the origin.
  const Eigen::RowVector3d origin = pose.row(0);
  for (Eigen::Index i = 0; i < pose.rows(); ++i) {
    const Eigen::RowVector3d row = state.gradient.row(i).head<3>() / 6;
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
  VolumeJob job = JobOf(pose, faces);
  for (job.end = 0; job.begin < faces.rows(); job.begin = job.end) {
    const int part = parts[faces(job.begin, 0)];
    while (job.end < faces.rows() && parts[faces(job.end, 0)] == part) ++job.end;
    volume[part] +=
        (HasFused() ? fused::SumVolumes(job, pose.data()) : plain::SumVolumes(job, pose.data())) /
        6;
  }
  return volume;
}

double KeptVolume::StepFor(int part, double missing, double slope, double before) const {
  const double here = slope + 2 * curvature_[part] * before, first = missing / here;
  const double second = missing / (here + curvature_[part] * first);
  return std::abs(before + second) < kMostReach * diagonal_ ? second : 0.0;
}

}  // namespace keypose::motion
