#include "motion/tracking/pose_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

constexpr double kLargestTurn = 0.5, kLargestMove = 0.2;  // of one step: [rad], [m]

struct ViewSystem {
  PoseSystem system;
  double measured = 0;
};

/// Rows of residuals of what is fixed to one joint, without the columns that are always zero.
class JointRows {
 public:
  void Add(const DofVector& row, double value, const std::vector<int>& dofs) {
    for (const int dof : dofs) rows_.push_back(row[dof]);
    values_.push_back(value);
  }
  void AddTo(const std::vector<int>& dofs, PoseSystem* system) const {
    if (values_.empty()) return;
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Index count = SizeOf(values_), columns = SizeOf(dofs);
    const Eigen::Map<const Rows> rows(rows_.data(), count, columns);
    const Eigen::Map<const Eigen::VectorXd> values(values_.data(), count);
    const Eigen::MatrixXd matrix = rows.transpose() * rows;
    const Eigen::VectorXd gradient = rows.transpose() * values;
    for (Eigen::Index i = 0; i < columns; ++i) {
      for (Eigen::Index j = 0; j < columns; ++j) system->matrix(dofs[i], dofs[j]) += matrix(i, j);
      system->gradient[dofs[i]] += gradient[i];
    }
  }

 private:
  std::vector<double> rows_, values_;
};

ViewSystem SystemOfView(const Silhouette& silhouette, const ViewMatches& matches,
                        const PosedBody& body, double reach) {
  ViewSystem view;
  std::array<JointRows, kJoints> rows;
  VisitResiduals(silhouette, matches, body, [&](const OutlineResidual& r) {
    view.measured += r.stands_for;
    view.system.cost += r.stands_for * 2 * TukeyLoss(r.value, reach);
    const double weight = r.stands_for * TukeyWeight(r.value, reach);
    if (weight <= 0) return;
    const double root = std::sqrt(weight);
    const int joint = Segments()[r.sample->segment].joint;
    DofVector row = DofVector::Zero();
    body.AddPoseRow(joint, r.x, root * r.pull, row.data());
    rows[joint].Add(row, root * r.value, DofsThatMove(joint));
  });
  for (int j = 0; j < kJoints; ++j) rows[j].AddTo(DofsThatMove(j), &view.system);
  return view;
}

PoseSystem PriorSystem(const PosedBody& body, const BodyShape& shape, const DofVector& q,
                       const PoseOptions& options) {
  PoseSystem system;
  for (const QuadraticPrior& prior : options.priors) AddQuadratic(prior, q, &system);
  AddLimits(q, &system);
  AddOverlaps(body, shape, &system);
  return system;
}

DofVector StepOf(const PoseSystem& system) {
  DofMatrix damped = system.matrix;
  damped.diagonal() += 1e-4 * system.matrix.diagonal() + DofVector::Constant(1e-3);
  DofVector step = -damped.ldlt().solve(system.gradient);
  const double turn = step.tail<kDofs - 3>().cwiseAbs().maxCoeff();
  const double move = step.head<3>().cwiseAbs().maxCoeff();
  const double factor = std::max({1.0, turn / kLargestTurn, move / kLargestMove});
  return step / factor;
}

double ReachOf(const PoseOptions& options, int round) {
  if (options.first_reach <= options.reach || options.rounds < 2) return options.reach;
  const double share = static_cast<double>(round) / (options.rounds - 1);
  return options.first_reach * std::pow(options.reach / options.first_reach, share);
}

}  // namespace

PoseSystem OutlineSystem(const std::vector<Silhouette>& silhouettes,
                         const std::vector<ViewMatches>& matches, const PosedBody& body,
                         double reach, double* measured) {
  std::vector<ViewSystem> views(silhouettes.size());
  ParallelFor(SizeOf(silhouettes), [&](std::int64_t v) {
    views[v] = SystemOfView(silhouettes[v], matches[v], body, reach);
  });
  ViewSystem sum;
  for (const ViewSystem& view : views) {
    sum.system += view.system;
    sum.measured += view.measured;
  }
  if (measured) *measured = sum.measured;
  return sum.system;
}

std::vector<ViewMatches> FindAllMatches(const std::vector<Silhouette>& silhouettes,
                                        const LocalSurface& surface, const PosedBody& body,
                                        double reach) {
  std::vector<ViewMatches> matches(silhouettes.size());
  ParallelFor(SizeOf(silhouettes), [&](std::int64_t v) {
    matches[v] = FindMatches(silhouettes[v], surface, body, reach);
  });
  return matches;
}

PoseFit SolvePose(const std::vector<Silhouette>& silhouettes, const BodyShape& shape,
                  const LocalSurface& surface, const BodyPose& start, const PoseOptions& options) {
  PoseFit fit;
  fit.pose = start;
  std::vector<ViewMatches> matches;
  for (int round = 0; round < options.rounds; ++round) {
    const double reach = ReachOf(options, round);
    PosedBody body = Posed(fit.pose, shape);
    matches = FindAllMatches(silhouettes, surface, body, 2 * reach);
    for (int step = 0; step < options.steps; ++step) {
      if (step > 0) body = Posed(fit.pose, shape);
      PoseSystem system = OutlineSystem(silhouettes, matches, body, reach);
      system += PriorSystem(body, shape, fit.pose.q, options);
      fit.pose.q += StepOf(system);
    }
  }
  const PosedBody body = Posed(fit.pose, shape);
  fit.data = OutlineSystem(silhouettes, matches, body, options.reach, &fit.measured);
  fit.cost = fit.data.cost / std::max(1.0, fit.measured);
  double points = 0, unexplained = 0;
  for (std::size_t v = 0; v < silhouettes.size(); ++v) {
    points += static_cast<double>(silhouettes[v].outline.size());
    unexplained += matches[v].unexplained;
  }
  fit.unexplained = unexplained / std::max(1.0, points);
  return fit;
}

DofVector StandardDeviations(const PoseFit& fit) {
  // A residual's variance; a pixel's half at least. A template's errors are alike over whole limbs,
  // so that far fewer residuals are independent than the matrix counts.
  constexpr double kIndependent = 0.03;
  DofMatrix information = kIndependent * fit.data.matrix / std::max(0.25, fit.cost);
  for (int i = 0; i < kDofs; ++i) {
    const DofModel& dof = Dofs()[i];
    // Evenly spread over its range, a number has the range over the root of 12.
    double spread = dof.low == dof.high ? kPi : (dof.high - dof.low) / std::sqrt(12.0);
    if (i < 3) spread = 1.0;
    information(i, i) += 1 / (spread * spread);
  }
  return information.ldlt().solve(DofMatrix::Identity()).diagonal().cwiseMax(0).cwiseSqrt();
}

}  // namespace keypose::motion
