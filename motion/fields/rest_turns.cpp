#include "motion/fields/rest_turns.h"

#include <Eigen/SVD>
#include <algorithm>

#include "core/numbers/rotations.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::motion {

namespace {

// Chosen on two bodies of other shapes and arms (docs/results/transfer.md).
struct RestTurnsTuning {
  KEYPOSE_TUNED(double, kPull, 1.0);    // towards no turn, against one neighbour's vector
  KEYPOSE_TUNED(int, kAverages, 2);     // rounds over the neighbours
  KEYPOSE_TUNED(double, kNone, 6.0);    // deg: differences of shape
  KEYPOSE_TUNED(double, kWhole, 18.0);  // deg: surely another pose
};

Eigen::Matrix3d PolarOf(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double side = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, side).asDiagonal() * svd.matrixV().transpose();
}

double Faded(double angle) {
  const double x = std::clamp((angle / kDegree - RestTurnsTuning::kNone) /
                                  (RestTurnsTuning::kWhole - RestTurnsTuning::kNone),
                              0.0, 1.0);
  return x * x * (3 - 2 * x);
}

}  // namespace

std::vector<Eigen::Quaterniond> RestTurns(const MarkTree& tree, const PointsX3& on_template,
                                          const PointsX3& on_target) {
  const int count = SizeOf(tree.nearest);
  std::vector<Eigen::Vector3d> logs(count, Eigen::Vector3d::Zero());
  for (int k = 0; k < count; ++k) {
    Eigen::Matrix3d moments = RestTurnsTuning::kPull * Eigen::Matrix3d::Identity();
    for (int j : tree.nearest[k]) {
      const Eigen::Vector3d from = on_target.row(j) - on_target.row(k),
                            to = on_template.row(j) - on_template.row(k);
      if (from.norm() > 0 && to.norm() > 0)
        moments += to.normalized() * from.normalized().transpose();
    }
    logs[k] = LogOf(PolarOf(moments));
  }
  for (int round = 0; round < RestTurnsTuning::kAverages; ++round) {
    const std::vector<Eigen::Vector3d> before = logs;
    for (int k = 0; k < count; ++k) {
      for (int j : tree.nearest[k]) logs[k] += before[j];
      logs[k] /= 1.0 + static_cast<double>(tree.nearest[k].size());
    }
  }
  std::vector<Eigen::Quaterniond> turns;
  for (const Eigen::Vector3d& log : logs) turns.push_back(QuaternionOf(Faded(log.norm()) * log));
  return turns;
}

}  // namespace keypose::motion
