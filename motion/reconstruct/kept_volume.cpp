#include "motion/reconstruct/kept_volume.h"

#include "core/geometry.h"

namespace keypose::motion {

KeptVolume::KeptVolume(const PoissonSystem& system, const PointsX3& rest)
    : system_(&system), correction_(system), rest_volumes_(correction_.Volumes(rest)) {
  for (const double volume : rest_volumes_) rest_sum_ += volume;
  const PointsX3 direction = correction_.Direction(rest),
                 normals = VertexNormals(rest, system.faces());
  amount_ = direction.cwiseProduct(normals).rowwise().sum().cwiseMax(0.0);
}

VolumeCorrection::Result KeptVolume::Apply(PointsX3& pose) const {
  if (!any_closed()) return {};
  PointsX3 direction = VertexNormals(pose, system_->faces());
  direction.array().colwise() *= amount_.array();
  return correction_.Apply(pose, std::move(direction), rest_volumes_);
}

double KeptVolume::VolumeOf(const PointsX3& pose) const {
  if (!any_closed()) return 1;
  double sum = 0;
  for (const double volume : correction_.Volumes(pose)) sum += volume;
  return sum / rest_sum_;
}

}  // namespace keypose::motion
