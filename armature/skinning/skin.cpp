#include "armature/skinning/skin.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Vector3d;

namespace {

/// x y z w of the turn, then of the dual part.
using DualQuaternion = Eigen::Matrix<double, 8, 1>;

DualQuaternion DualOf(const Rigid3& motion) {
  const Eigen::Quaterniond& q = motion.rotation;
  const Eigen::Quaterniond shift(0, motion.translation.x(), motion.translation.y(),
                                 motion.translation.z());
  DualQuaternion dual;
  dual << q.coeffs(), 0.5 * (shift * q).coeffs();
  return dual;
}

/// The sum of the motions, made a motion again, applied to a point.
Vector3d Moved(const DualQuaternion& sum, const Vector3d& x) {
  const double inverse = 1 / sum.head<4>().squaredNorm();
  const Vector3d turn = sum.head<3>(), dual = sum.segment<3>(4);
  const double w = sum[3];
  const Vector3d twice = 2 * inverse * turn.cross(turn.cross(x) + w * x);
  return x + twice + 2 * inverse * (w * dual - sum[7] * turn + turn.cross(dual));
}

}  // namespace

SkinWeights Pruned(const Eigen::MatrixXd& dense) {
  const int most = std::min<int>(SkinWeights::kMost, static_cast<int>(dense.cols()));
  SkinWeights skin;
  skin.bones.resize(dense.rows(), {});
  skin.weights.resize(dense.rows(), {});
  ParallelBlocks(dense.rows(), 256, [&](std::int64_t begin, std::int64_t end) {
    std::vector<int> order(dense.cols());
    for (std::int64_t v = begin; v < end; ++v) {
      std::iota(order.begin(), order.end(), 0);
      std::partial_sort(order.begin(), order.begin() + most, order.end(), [&](int a, int b) {
        return dense(v, a) != dense(v, b) ? dense(v, a) > dense(v, b) : a < b;
      });
      double sum = 0;
      for (int k = 0; k < most; ++k) sum += std::max(dense(v, order[k]), 0.0);
      for (int k = 0; k < most; ++k) {
        skin.bones[v][k] = static_cast<std::uint16_t>(sum > 0 ? order[k] : 0);
        skin.weights[v][k] = sum > 0 ? std::max(dense(v, order[k]), 0.0) / sum : k == 0;
      }
    }
  });
  return skin;
}

Skin::Skin(const PointsX3& rest, SkinWeights weights, int bone_count)
    : rest_(rest), weights_(std::move(weights)), bone_count_(bone_count) {
  if (weights_.vertex_count() != rest.rows())
    throw InputError("armature: weights for " + std::to_string(weights_.vertex_count()) +
                     " vertices, but the mesh has " + std::to_string(rest.rows()));
  if (!rest.allFinite()) throw InputError("armature: the mesh has a vertex that is not finite");
  for (const auto& bones : weights_.bones)
    for (const int bone : bones)
      if (bone >= bone_count)
        throw InputError("armature: weights of bone " + std::to_string(bone) + " of " +
                         std::to_string(bone_count));
}

void Skin::Pose(const std::vector<Rigid3>& bones, PointsX3* points,
                const std::vector<char>& moved) const {
  std::vector<DualQuaternion> duals(bone_count_);
  for (int b = 0; b < bone_count_; ++b) duals[b] = DualOf(bones[b]);
  const bool all = moved.empty() || points->rows() != rest_.rows();
  if (points->rows() != rest_.rows()) points->resize(rest_.rows(), 3);
  for (Eigen::Index v = 0; v < rest_.rows(); ++v) {
    const auto& index = weights_.bones[v];
    const auto& weight = weights_.weights[v];
    // Bones of weight 0 are the first one or real ones; to look at them too does no harm.
    if (!all && !moved[index[0]] && !moved[index[1]] && !moved[index[2]] && !moved[index[3]])
      continue;
    // Of a motion's two dual quaternions the one nearer to the heaviest bone's.
    const DualQuaternion& first = duals[index[0]];
    DualQuaternion sum = weight[0] * first;
    for (int k = 1; k < SkinWeights::kMost && weight[k] > 0; ++k) {
      const DualQuaternion& next = duals[index[k]];
      const double sign = next.head<4>().dot(first.head<4>()) < 0 ? -weight[k] : weight[k];
      sum += sign * next;
    }
    points->row(v) = Moved(sum, rest_.row(v));
  }
}

}  // namespace keypose::armature
