#include "composite/locating/lens/normal_equations.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "core/numbers/rotations.h"

namespace keypose::composite {
namespace {

std::vector<int> Indices(const std::array<bool, kUnknowns>& free_unknowns) {
  std::vector<int> indices;
  for (int i = 0; i < kUnknowns; ++i)
    if (free_unknowns[i]) indices.push_back(i);
  return indices;
}

}  // namespace

Eigen::Matrix3d CrossOf(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

PixelDerivatives DerivativesAt(const Camera& c, const Eigen::Vector3d& x) {
  const double u = x.x() / x.z(), v = x.y() / x.z(), r2 = u * u + v * v;
  const double radial = 1 + r2 * (c.k1 + r2 * c.k2), slope = 2 * (c.k1 + 2 * r2 * c.k2);
  Eigen::Matrix2d bent;  // of the distorted by the ideal coordinates
  bent << radial + u * u * slope + 2 * c.p1 * v + 6 * c.p2 * u,
      u * v * slope + 2 * c.p1 * u + 2 * c.p2 * v, u * v * slope + 2 * c.p2 * v + 2 * c.p1 * u,
      radial + v * v * slope + 2 * c.p2 * u + 6 * c.p1 * v;
  Eigen::Matrix<double, 2, 3> ideal;
  ideal << 1 / x.z(), 0, -u / x.z(), 0, 1 / x.z(), -v / x.z();
  const Eigen::Vector2d focal(c.fx, c.fy);
  PixelDerivatives d;
  d.by_point = focal.asDiagonal() * bent * ideal;
  d.by_log_focal = c.Project(x) - Eigen::Vector2d(c.cx, c.cy);
  d.by_k1 = r2 * focal.cwiseProduct(Eigen::Vector2d(u, v));
  return d;
}

NormalEquations::NormalEquations(const Placement& at, const Eigen::Vector3d& center, double radius)
    : at_(at),
      center_in_camera_(at.camera_from_mesh * center),
      turn_(at.camera_from_mesh.rotation.toRotationMatrix()),
      radius_(radius) {}

void NormalEquations::Add(const Eigen::Vector3d& x_in_mesh, const Eigen::Vector2d& direction,
                          double distance_px, double weight, bool of_matte) {
  const Eigen::Vector3d x = turn_ * x_in_mesh + at_.camera_from_mesh.translation;
  if (x.z() <= 0) return;
  const PixelDerivatives d = DerivativesAt(at_.camera, x);
  const Eigen::RowVector3d pull = direction.transpose() * d.by_point;
  Step j;
  j.head<3>() = -(pull * CrossOf(x - center_in_camera_)).transpose();
  j.segment<3>(3) = radius_ * pull.transpose();
  j[kLogFocal] = direction.dot(d.by_log_focal);
  j[kK1] = direction.dot(d.by_k1);
  j[kMatteOffset] = of_matte ? 1 : 0;
  j.segment<2>(kCenterX) = direction;
  h_.noalias() += weight * j * j.transpose();
  g_ += weight * distance_px * j;
  cost_ += weight * distance_px * distance_px;
}

void NormalEquations::AddPrior(int i, double distance, double weight) {
  h_(i, i) += weight;
  g_[i] += weight * distance;
  cost_ += weight * distance * distance;
}

void NormalEquations::Add(const NormalEquations& other) {
  h_ += other.h_;
  g_ += other.g_;
  cost_ += other.cost_;
}

Step NormalEquations::Solve(const std::array<bool, kUnknowns>& free_unknowns,
                            double damping) const {
  const std::vector<int> free = Indices(free_unknowns);
  Eigen::MatrixXd h = h_(free, free);
  // Columns are scaled to one, since a radian moves pixels a thousand times as much as k1 does.
  const Eigen::VectorXd scale =
      h.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
  h = (scale.asDiagonal() * h * scale.asDiagonal()).eval();
  h.diagonal().array() += damping + 1e-12;
  const Eigen::VectorXd g = scale.cwiseProduct(Eigen::VectorXd(g_(free)));
  const Eigen::VectorXd solved = scale.cwiseProduct(h.ldlt().solve(g));
  Step step = Step::Zero();
  if (solved.allFinite()) step(free) = solved;
  return step;
}

Placement NormalEquations::Moved(const Step& step) const {
  Placement moved = at_;
  const Eigen::Quaterniond turn = QuaternionOf(step.head<3>());
  const Eigen::Vector3d center = center_in_camera_ + radius_ * step.segment<3>(3);
  const Rigid3& pose = at_.camera_from_mesh;
  moved.camera_from_mesh = {(turn * pose.rotation).normalized(),
                            center + turn * (pose.translation - center_in_camera_)};
  const double factor = std::exp(step[kLogFocal]);
  moved.camera.fx *= factor;
  moved.camera.fy *= factor;
  moved.camera.k1 += step[kK1];
  return moved;
}

double NormalEquations::Deviation(int i, const std::array<bool, kUnknowns>& free_unknowns) const {
  std::vector<int> rest;
  for (const int k : Indices(free_unknowns))
    if (k != i) rest.push_back(k);
  const Eigen::MatrixXd h = h_(rest, rest);
  const Eigen::VectorXd cross = h_(rest, i);
  const double left = h_(i, i) - cross.dot(h.completeOrthogonalDecomposition().solve(cross));
  if (!(left > 1e-12 * h_(i, i))) return std::numeric_limits<double>::infinity();
  return 1 / std::sqrt(left);
}

double NormalEquations::TurnEigenvalueRatio(Eigen::Vector3d* axis) const {
  const Eigen::Matrix3d turn = h_.topLeftCorner<3, 3>(), cross = h_.block<3, 3>(0, 3);
  const Eigen::Matrix3d shift = h_.block<3, 3>(3, 3);
  const Eigen::Matrix3d left =
      turn - cross * shift.completeOrthogonalDecomposition().solve(cross.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(left);
  if (axis) *axis = solver.eigenvectors().col(0);
  const double greatest = turn.trace();
  return greatest > 0 ? std::max(0.0, solver.eigenvalues()[0]) / greatest : 0;
}

std::array<bool, kUnknowns> FreeUnknowns(bool focal, bool k1) {
  return {true, true, true, true, true, true, focal, k1, false, false, false};
}

}  // namespace keypose::composite
