#include "fit/bending/joint_solve.h"

#include <cmath>
#include <map>

#include "core/numbers/cholesky.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

using Matrix36 = Eigen::Matrix<double, 3, 6>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// How a point moves with respect to the camera, in the world's axes, when the camera's pose gets
/// the step (turn, shift) from the left.
Matrix36 MoveByPose(const Rigid3& pose, const Eigen::Vector3d& x) {
  Matrix36 move;
  const Eigen::Matrix3d back = pose.rotation.conjugate().toRotationMatrix();
  move << -back * Cross(pose * x), back;
  return move;
}

Rigid3 Moved(const Rigid3& pose, const Vector6& step) {
  const Eigen::Vector3d turn = step.head<3>();
  const double angle = turn.norm();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  if (angle > 1e-15) rotation = Eigen::AngleAxisd(angle, turn / angle);
  return {(rotation * pose.rotation).normalized(), rotation * pose.translation + step.tail<3>()};
}

/// The system's blocks, before they are joined.
struct Blocks {
  std::vector<Eigen::Matrix3d> vertex;            // V
  std::vector<std::map<int, Matrix36>> coupling;  // by view: vertex to block
  std::vector<Matrix6> pose;
  Eigen::VectorXd right;  // 3 V + 6 C
};

Blocks Collect(const PointsX3& now, const std::vector<LevelConstraint>& constraints,
               const Pulls& pulls, const std::vector<Rigid3>& poses) {
  const Eigen::Index vertices = now.rows(), views = SizeOf(poses);
  Blocks blocks{pulls.q, std::vector<std::map<int, Matrix36>>(views),
                std::vector<Matrix6>(views, Matrix6::Zero()),
                Eigen::VectorXd::Zero(3 * vertices + 6 * views)};
  for (const LevelConstraint& c : constraints) {
    if (c.view < 0) continue;  // among the pulls
    const Eigen::Vector3d p = now.row(c.vertex), goal = c.goal - c.arm;
    const Matrix36 move = MoveByPose(poses[c.view], p + c.arm);
    const Matrix36 coupled = c.q * move;
    blocks.vertex[c.vertex] += c.q;
    auto [at, added] = blocks.coupling[c.view].emplace(c.vertex, coupled);
    if (!added) at->second += coupled;
    blocks.pose[c.view] += move.transpose() * coupled;
    blocks.right.segment<3>(3 * c.vertex) += c.q * goal;
    blocks.right.segment<6>(3 * vertices + 6 * c.view) += coupled.transpose() * goal;
  }
  return blocks;
}

Eigen::SparseMatrix<double> Joined(const Eigen::SparseMatrix<double>& shape, const Blocks& blocks) {
  const int vertices = SizeOf(blocks.vertex);
  const Eigen::Index size = blocks.right.size();
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int row, int column, double value) {
    if (row >= column) entries.emplace_back(row, column, value);
  };
  for (int column = 0; column < shape.outerSize(); ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator it(shape, column); it; ++it)
      for (int k = 0; k < 3; ++k)
        add(3 * static_cast<int>(it.row()) + k, 3 * column + k, it.value());
  for (int v = 0; v < vertices; ++v)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c <= r; ++c) add(3 * v + r, 3 * v + c, blocks.vertex[v](r, c));
  for (int view = 0; view < SizeOf(blocks.pose); ++view) {
    const int first = 3 * vertices + 6 * view;
    for (const auto& [v, block] : blocks.coupling[view])
      for (int r = 0; r < 6; ++r)
        for (int c = 0; c < 3; ++c) add(first + r, 3 * v + c, block(c, r));
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c <= r; ++c) add(first + r, first + c, blocks.pose[view](r, c));
  }
  Eigen::SparseMatrix<double> lower(size, size);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

}  // namespace

PointsX3 SolveJointly(const ArapFit& fit, const PointsX3& now,
                      const std::vector<LevelConstraint>& constraints, const Pulls& pulls,
                      double holding, std::vector<Rigid3>& poses) {
  Blocks blocks = Collect(now, constraints, pulls, poses);
  const Eigen::Index vertices = now.rows();
  const PointsX3 shape_pull = fit.ShapePull();
  for (Eigen::Index v = 0; v < vertices; ++v)
    blocks.right.segment<3>(3 * v) += (shape_pull.row(v) + pulls.b.row(v)).transpose();
  for (Matrix6& pose : blocks.pose) pose.diagonal() *= 1 + holding;
  for (Matrix6& pose : blocks.pose) pose.diagonal().array() += 1e-6;
  for (Eigen::Matrix3d& vertex : blocks.vertex) vertex.diagonal().array() += 1e-9;
  const Eigen::SparseMatrix<double> lower = Joined(fit.shape_matrix(), blocks);
  SparseCholesky factor;
  factor.Analyze(lower);
  factor.Factor(lower);
  const Eigen::VectorXd x = factor.Solve(blocks.right);
  PointsX3 points(vertices, 3);
  for (Eigen::Index v = 0; v < vertices; ++v) points.row(v) = x.segment<3>(3 * v).transpose();
  for (int view = 0; view < SizeOf(poses); ++view)
    poses[view] = Moved(poses[view], x.segment<6>(3 * vertices + 6 * view));
  return points;
}

}  // namespace keypose::fit
