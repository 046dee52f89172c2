#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "armature/matching/chain_match.h"
#include "armature/matching/closing.h"
#include "armature/matching/match_parts.h"
#include "armature/matching/testing/curves.h"
#include "armature/matching/testing/spines.h"
#include "core/values/errors.h"

namespace keypose::armature::both_ends_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

ChainMatch BothEnds(const Polyline& curve, const VectorXd& lengths,
                    const MatchOptions& options = {}) {
  return MatchBothEnds(curve, lengths, {}, nullptr, options);
}

TEST(MatchBothEnds, SameChainLiesOnItsCurve) {
  const Polyline curve = Hook();
  const ChainMatch match = BothEnds(curve, PiecesOf(curve));
  EXPECT_LT((match.joints - curve.points()).norm(), 1e-12);
  EXPECT_LT(match.mean_distance, 1e-12);
}

TEST(MatchBothEnds, StraightChainStaysStraight) {
  PointsX3 points(3, 3);
  points << 0, 0, 0, 0, 0, 1, 0, 0, 3;
  const Polyline curve(points);
  const ChainMatch match = BothEnds(curve, VectorXd::Constant(6, 0.5));
  EXPECT_TRUE(match.reachable);
  EXPECT_LT(match.far_gap, 3e-13);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(match.directions(k, 2), 1, 1e-12);
}

// Two rods reach between two points in one plane only as the law of cosines says.
TEST(MatchBothEnds, TwoRodsFollowTheLawOfCosines) {
  PointsX3 points(3, 3);
  points << 0, 0, 0, 1.4, 0.9, 0, 2.3, 0, 0;
  const double first = 1.9, second = 1.1, distance = 2.3;
  const ChainMatch match = BothEnds(Polyline(points), Eigen::Vector2d(first, second));
  const double cosine =
      (first * first + distance * distance - second * second) / (2 * first * distance);
  EXPECT_NEAR(match.directions(0, 0), cosine, 1e-12);
  EXPECT_NEAR(match.directions(0, 1), std::sqrt(1 - cosine * cosine), 1e-12);
  EXPECT_NEAR(match.directions(0, 2), 0, 1e-9);
}

TEST(MatchBothEnds, RandomChainsMeetBothAnchorsAndNoneFails) {
  double both = 0, greedy = 0, greedy_far = 0;
  const auto chains = MakeRandomChains(2000, 5);
  for (const RandomChain& chain : chains) {
    const Polyline curve(chain.curve);
    const double length = chain.lengths.sum();
    const ChainMatch match = BothEnds(curve, chain.lengths);
    ASSERT_TRUE(match.reachable && match.converged);
    ASSERT_LE(match.near_gap, 1e-12 * length);
    ASSERT_LE(match.far_gap, 1e-12 * length);
    for (Eigen::Index i = 0; i < chain.lengths.size(); ++i)
      ASSERT_NEAR((match.joints.row(i + 1) - match.joints.row(i)).norm(), chain.lengths[i],
                  1e-12 * length);
    both += match.mean_distance / length;
    const ChainMatch paper = MatchGreedily(curve, chain.lengths);
    greedy += paper.mean_distance / length;
    greedy_far = std::max(greedy_far, paper.far_gap / length);
  }
  both /= static_cast<double>(chains.size());
  EXPECT_LT(both, 0.015);       // of the chain's length
  EXPECT_GT(greedy_far, 0.06);  // what the paper's way leaves at the end
  EXPECT_LT(greedy / static_cast<double>(chains.size()), 1e-3);  // it stays on the curve instead
}

TEST(MatchBothEnds, MirroredCurveGivesMirroredChain) {
  for (const RandomChain& chain : MakeRandomChains(50, 8)) {
    PointsX3 mirrored = chain.curve;
    mirrored.col(0) *= -1;
    PointsX3 joints = BothEnds(Polyline(chain.curve), chain.lengths).joints;
    joints.col(0) *= -1;
    const PointsX3 other = BothEnds(Polyline(mirrored), chain.lengths).joints;
    EXPECT_LT((joints - other).rowwise().norm().maxCoeff(), 1e-8 * chain.lengths.sum());
  }
}

TEST(MatchBothEnds, StartDoesNotDecideWhereItEnds) {
  for (const RandomChain& chain : MakeRandomChains(50, 9)) {
    const Polyline curve(chain.curve);
    const ChainMatch match = BothEnds(curve, chain.lengths);
    ChainMatch before = match;
    for (Eigen::Index i = 0; i < before.directions.rows(); ++i)
      before.directions.row(i) =
          (before.directions.row(i) + 0.2 * Eigen::RowVector3d(std::sin(i), std::cos(i), 0.5))
              .normalized();
    const ChainMatch again = MatchBothEnds(curve, chain.lengths, {}, &before, {});
    EXPECT_LT((match.joints - again.joints).rowwise().norm().maxCoeff(),
              1e-8 * chain.lengths.sum());
  }
}

TEST(MatchBothEnds, CalmChainLagsBehindAndComesToRest) {
  const RandomChain chain = MakeRandomChains(1, 3)[0];
  const Polyline curve(chain.curve);
  MatchOptions calm;
  calm.calm_weight = 0.1;
  const ChainMatch goal = BothEnds(curve, chain.lengths);
  ChainMatch match = goal;
  match.directions = goal.directions.rowwise() + Eigen::RowVector3d(0.1, -0.1, 0.05);
  match.directions.rowwise().normalize();
  double before = 1e300;
  for (int round = 0; round < 200; ++round) {
    match = MatchBothEnds(curve, chain.lengths, {}, &match, calm);
    const double off = (match.directions - goal.directions).norm();
    EXPECT_LE(off, before + 1e-9);
    if (round == 0) {
      EXPECT_GT(off, 1e-3);
    }
    before = off;
  }
  EXPECT_LT(before, 1e-5);
}

/// The same cost for Ceres: joints' offsets, rods' directions, and the far anchor.
class OracleCost final : public ceres::CostFunction {
 public:
  OracleCost(const Polyline& curve, const VectorXd& lengths, const Directions& wanted,
             double direction_weight)
      : curve_(curve),
        lengths_(lengths),
        parts_(PartsOf(curve, lengths)),
        wanted_(wanted),
        weight_(std::sqrt(direction_weight)) {
    const int rods = static_cast<int>(lengths.size());
    for (int i = 0; i < rods; ++i) mutable_parameter_block_sizes()->push_back(3);
    set_num_residuals(3 * (rods - 1) + 3 * rods + 3);
  }
  double penalty = 1;
  Vector3d multiplier = Vector3d::Zero();

  Vector3d Missing(const Directions& u) const {
    Vector3d sum = curve_.points().row(0) - curve_.points().bottomRows<1>();
    for (std::size_t i = 0; i < u.size(); ++i) sum += lengths_[i] * u[i];
    return sum / lengths_.sum();
  }

  bool Evaluate(double const* const* u, double* residuals, double** jacobians) const override {
    const int rods = static_cast<int>(lengths_.size());
    const double scale = 1 / lengths_.sum(), root = std::sqrt(penalty);
    Eigen::Map<VectorXd> r(residuals, num_residuals());
    Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(num_residuals(), 3 * rods);
    Vector3d joint = curve_.points().row(0);
    Directions directions;
    for (int i = 0; i < rods; ++i) {
      directions.emplace_back(u[i][0], u[i][1], u[i][2]);
      const int row = 3 * (rods - 1) + 3 * i;
      r.segment<3>(row) = weight_ * (directions[i] - wanted_[i]);
      derivative.block<3, 3>(row, 3 * i).diagonal().setConstant(weight_);
      derivative.block<3, 3>(num_residuals() - 3, 3 * i)
          .diagonal()
          .setConstant(root * lengths_[i] * scale);
      joint += lengths_[i] * directions[i];
      if (i + 1 == rods) break;
      const Polyline::Foot foot = curve_.Nearest(joint, parts_[i].from, parts_[i].to);
      r.segment<3>(3 * i) = (joint - foot.point) * scale;
      const Eigen::Matrix3d across =
          Eigen::Matrix3d::Identity() - foot.along * foot.along.transpose();
      for (int j = 0; j <= i; ++j)
        derivative.block<3, 3>(3 * i, 3 * j) = lengths_[j] * scale * across;
    }
    r.tail<3>() = root * (Missing(directions) + multiplier / penalty);
    for (int i = 0; jacobians && i < rods; ++i)
      if (jacobians[i])
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
            jacobians[i], num_residuals(), 3) = derivative.middleCols<3>(3 * i);
    return true;
  }

 private:
  const Polyline& curve_;
  VectorXd lengths_;
  std::vector<CurvePart> parts_;
  Directions wanted_;
  double weight_;
};

/// Augmented Lagrangian on spheres: slow, and nothing like the solver that it checks.
Directions SolvedByCeres(const Polyline& curve, const VectorXd& lengths, double weight) {
  const Directions wanted = CurveDirections(curve, lengths);
  OracleCost cost(curve, lengths, wanted, weight);
  Directions u = wanted;
  for (int outer = 0; outer < 12; ++outer) {
    ceres::Problem::Options borrowed;
    borrowed.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(borrowed);
    std::vector<double*> blocks;
    for (Vector3d& direction : u) blocks.push_back(direction.data());
    problem.AddResidualBlock(&cost, nullptr, blocks);
    for (double* block : blocks) problem.SetManifold(block, new ceres::SphereManifold<3>);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 2000;
    options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    cost.multiplier += cost.penalty * cost.Missing(u);
    cost.penalty = std::min(cost.penalty * 10, 1e3);
  }
  return u;
}

TEST(MatchBothEnds, AgreesWithCeres) {
  for (const RandomChain& chain : MakeRandomChains(25, 21)) {
    const Polyline curve(chain.curve);
    const ChainMatch match = BothEnds(curve, chain.lengths);
    const Directions other = SolvedByCeres(curve, chain.lengths, MatchOptions().direction_weight);
    for (Eigen::Index i = 0; i < chain.lengths.size(); ++i)
      EXPECT_LT((match.directions.row(i).transpose() - other[i]).norm(), 1e-6) << i;
  }
}

TEST(MatchBothEnds, CostIsLeastWhereItEnds) {
  const RandomChain chain = MakeRandomChains(1, 30)[0];
  const Polyline curve(chain.curve);
  const ChainMatch match = BothEnds(curve, chain.lengths);
  const double least = MatchCost(curve, chain.lengths, {}, nullptr, {}, match.directions);
  const Vector3d span = curve.points().bottomRows<1>() - curve.points().row(0);
  for (int trial = 0; trial < 40; ++trial) {
    Directions u = DirectionsOf(match.directions);
    for (std::size_t i = 0; i < u.size(); ++i)
      u[i] = (u[i] + 0.01 * Vector3d(std::sin(trial + 3.0 * i), std::cos(2.0 * trial + i),
                                     std::sin(5.0 * trial - i)))
                 .normalized();
    ASSERT_TRUE(CloseChain(chain.lengths, span, u));
    PointsX3 rows(static_cast<Eigen::Index>(u.size()), 3);
    for (std::size_t i = 0; i < u.size(); ++i) rows.row(i) = u[i];
    EXPECT_GT(MatchCost(curve, chain.lengths, {}, nullptr, {}, rows), least);
  }
}

PointsX3 StraightCurve(double length) {
  PointsX3 points = PointsX3::Zero(3, 3);
  points(1, 1) = 0.4 * length, points(2, 1) = length;
  return points;
}

TEST(Unreachable, ShortChainLiesStraightAndThePolicyPlacesTheGap) {
  const Polyline curve(StraightCurve(3));
  const Eigen::Vector3d lengths(0.8, 0.7, 0.5);
  MatchOptions options;
  options.unreachable = Unreachable::kKeepNear;
  const ChainMatch near = BothEnds(curve, lengths, options);
  EXPECT_FALSE(near.reachable);
  EXPECT_NEAR(near.near_gap, 0, 1e-15);
  EXPECT_NEAR(near.far_gap, 1, 1e-12);
  options.unreachable = Unreachable::kKeepFar;
  const ChainMatch far = BothEnds(curve, lengths, options);
  EXPECT_NEAR(far.near_gap, 1, 1e-12);
  EXPECT_NEAR(far.far_gap, 0, 1e-12);
  options.unreachable = Unreachable::kSplit;
  const ChainMatch split = BothEnds(curve, lengths, options);
  EXPECT_NEAR(split.near_gap, 0.5, 1e-12);
  EXPECT_NEAR(split.far_gap, 0.5, 1e-12);
  EXPECT_NEAR(split.directions(2, 1), 1, 1e-15);
}

TEST(Unreachable, ChainWithOneLongRodFoldsBack) {
  const Polyline curve(StraightCurve(0.5));
  MatchOptions options;
  options.unreachable = Unreachable::kKeepNear;
  const ChainMatch match = BothEnds(curve, Eigen::Vector3d(0.5, 3, 0.5), options);
  EXPECT_FALSE(match.reachable);
  EXPECT_NEAR(match.far_gap, 1.5, 1e-12);
  EXPECT_NEAR(match.directions(0, 1), -1, 1e-15);
  EXPECT_NEAR(match.directions(1, 1), 1, 1e-15);
}

TEST(Unreachable, ChainComesStraightWithoutAJump) {
  const Eigen::Vector3d lengths(1, 1.1, 0.9);
  ChainMatch before = BothEnds(Polyline(StraightCurve(2.9)), lengths);
  for (double length = 2.9; length < 3.02; length += 1e-4) {
    const ChainMatch match =
        MatchBothEnds(Polyline(StraightCurve(length)), lengths, {}, &before, {});
    EXPECT_EQ(match.reachable, length <= 3 + 1e-9) << length;
    // The bend is the square root of what is missing to straight.
    EXPECT_LT((match.directions - before.directions).norm(), 0.04) << length;
    before = match;
  }
}

TEST(MatchBothEnds, BadInputThrowsInputError) {
  const Polyline curve = Hook();
  EXPECT_THROW(BothEnds(curve, VectorXd()), InputError);
  EXPECT_THROW(BothEnds(curve, Eigen::Vector2d(1, 0)), InputError);
  EXPECT_THROW(BothEnds(curve, Eigen::Vector2d(1, -2)), InputError);
  EXPECT_THROW(BothEnds(curve, Eigen::Vector2d(1, std::nan(""))), InputError);
  EXPECT_THROW(MatchBothEnds(curve, Eigen::Vector2d(3, 3), PointsX3::Ones(3, 3), nullptr, {}),
               InputError);
  EXPECT_THROW(MatchGreedily(curve, Eigen::Vector2d(1, 0)), InputError);
}

}  // namespace keypose::armature::both_ends_test
