// Newton's method for MatchBothEnds. All lengths are relative to the chain's.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "armature/matching/chain_match.h"
#include "armature/matching/closing.h"
#include "armature/matching/match_parts.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kLongestTurn = 0.5;  // [rad] of a rod in one step
constexpr double kFlat = 1e-13;       // gradient at which a minimum is reached
constexpr double kConstraintWeight = 10;
constexpr int kMostHalvings = 30;

/// A search's place: directions that end at the far anchor, and what is known there.
struct Place {
  Directions u;
  std::vector<Vector3d> offsets;  ///< of joint k+1 from its foot
  std::vector<Vector3d> along;    ///< the curve there, zero where the foot does not slide
  double cost = std::numeric_limits<double>::infinity();
};

class Search {
 public:
  Search(const Polyline& curve, const VectorXd& lengths, const Directions& wanted,
         const Directions& before, const MatchOptions& options)
      : curve_(curve),
        scale_(1 / lengths.sum()),
        lengths_(lengths),
        relative_(lengths * scale_),
        parts_(PartsOf(curve, lengths)),
        wanted_(wanted),
        before_(before),
        options_(options),
        start_(curve.points().row(0)),
        span_(curve.points().bottomRows<1>().transpose() - start_) {}

  /// Value of the cost, and the feet, for directions.
  void Evaluate(Place& place) const {
    const int rods = SizeOf(place.u);
    place.offsets.assign(rods - 1, Vector3d::Zero());
    place.along.assign(rods - 1, Vector3d::Zero());
    double cost = 0;
    Vector3d joint = start_;
    for (int k = 0; k + 1 < rods; ++k) {
      joint += lengths_[k] * place.u[k];
      const Polyline::Foot foot = curve_.Nearest(joint, parts_[k].from, parts_[k].to);
      place.offsets[k] = (joint - foot.point) * scale_;
      place.along[k] = foot.along;
      cost += 0.5 * place.offsets[k].squaredNorm();
    }
    for (int i = 0; i < rods; ++i) {
      cost += 0.5 * options_.direction_weight * (place.u[i] - wanted_[i]).squaredNorm();
      if (!before_.empty())
        cost += 0.5 * options_.calm_weight * (place.u[i] - before_[i]).squaredNorm();
    }
    place.cost = cost;
  }

  /// @return  whether the chain could be closed from these directions
  bool Begin(const Directions& u, Place& place) const {
    place.u = u;
    if (!CloseChain(lengths_, span_, place.u)) return false;
    Evaluate(place);
    return true;
  }

  /// Newton's steps from a closed chain to a minimum.
  bool Descend(Place& place, int* iterations) {
    double damping = 0;
    for (*iterations = 0; *iterations < options_.max_iterations; ++*iterations) {
      if (!Differentiate(place)) return true;
      const VectorXd step = StepOf(damping);
      Place next;
      if (!Walk(place, step, next)) {
        if (damping > 1e3) return gradient_.norm() < 1e3 * kFlat;
        damping = std::max(1e-6, 10 * damping);
        continue;
      }
      const double gain = place.cost - next.cost;
      place = std::move(next);
      damping = damping < 1e-6 ? 0 : 0.1 * damping;
      if (gain <= 1e-17 && step.norm() < 1e-9) return true;
    }
    return false;
  }

 private:
  /// Tangent bases, gradient and Hessian at a place.
  /// @return  false: the gradient along the constraint vanishes
  bool Differentiate(const Place& place) {
    const int rods = SizeOf(place.u);
    bases_.resize(rods);
    for (int i = 0; i < rods; ++i) bases_[i] = TangentBasis(place.u[i]);
    constraint_.resize(3, 2 * rods);
    VectorXd plain(2 * rods);
    std::vector<Vector3d> pull(rods);
    Vector3d sum = Vector3d::Zero();
    for (int i = rods - 1; i >= 0; --i) {
      if (i + 1 < rods) sum += place.offsets[i];
      pull[i] = relative_[i] * sum - options_.direction_weight * wanted_[i];
      if (!before_.empty()) pull[i] -= options_.calm_weight * before_[i];
      plain.segment<2>(2 * i) = bases_[i].transpose() * pull[i];
      constraint_.middleCols<2>(2 * i) = relative_[i] * bases_[i];
    }
    Matrix3d normal = constraint_ * constraint_.transpose();
    normal.diagonal().array() += 1e-14 * normal.trace();
    const Vector3d multiplier = -normal.ldlt().solve(constraint_ * plain);
    gradient_ = plain + constraint_.transpose() * multiplier;
    if (gradient_.norm() <= kFlat) return false;
    BuildHessian(place);
    curvature_.resize(rods);
    for (int i = 0; i < rods; ++i)
      curvature_[i] = -place.u[i].dot(pull[i] + relative_[i] * multiplier);
    return true;
  }

  /// Second derivatives of the distances. A foot that slides takes no part along the curve.
  void BuildHessian(const Place& place) {
    const int rods = SizeOf(place.u);
    hessian_.setZero(2 * rods, 2 * rods);
    Matrix3d weights = Matrix3d::Zero();
    for (int j = rods - 2; j >= 0; --j) {
      weights += Matrix3d::Identity() - place.along[j] * place.along[j].transpose();
      const Eigen::Matrix<double, 3, 2> column = relative_[j] * (weights * bases_[j]);
      for (int i = 0; i <= j; ++i)
        hessian_.block<2, 2>(2 * j, 2 * i) = column.transpose() * (relative_[i] * bases_[i]);
    }
  }

  /// Newton's step along the constraint. The constraint's own square, which does not change that
  /// step, makes the matrix positive wherever the cost bends upwards along the constraint;
  /// elsewhere the matrix is shifted until it is.
  VectorXd StepOf(double damping) const {
    MatrixXd system = hessian_;
    system.triangularView<Eigen::Lower>() +=
        kConstraintWeight * constraint_.transpose() * constraint_;
    for (int i = 0; i < SizeOf(curvature_); ++i)
      system.diagonal().segment<2>(2 * i).array() += curvature_[i] + damping;
    Eigen::LLT<MatrixXd> factor(system);
    for (double shift = 1e-5; factor.info() != Eigen::Success; shift *= 4) {
      system.diagonal().array() += shift;
      factor.compute(system);
    }
    const MatrixXd solved = factor.solve(constraint_.transpose());
    Matrix3d complement = constraint_ * solved;
    complement.diagonal().array() += 1e-14 * complement.trace();
    const VectorXd free = factor.solve(gradient_);
    VectorXd step = solved * complement.ldlt().solve(constraint_ * free) - free;
    double longest = 0;
    for (int i = 0; i < SizeOf(curvature_); ++i)
      longest = std::max(longest, step.segment<2>(2 * i).norm());
    if (longest > kLongestTurn) step *= kLongestTurn / longest;
    return step;
  }

  /// Goes along the step as far as the cost falls.
  bool Walk(const Place& from, const VectorXd& step, Place& to) const {
    const double slope = gradient_.dot(step);
    if (!(slope < 0)) return false;
    double share = 1;
    for (int halving = 0; halving < kMostHalvings; ++halving, share *= 0.5) {
      Directions u = from.u;
      for (int i = 0; i < SizeOf(u); ++i)
        u[i] = (u[i] + share * (bases_[i] * step.segment<2>(2 * i))).normalized();
      if (!Begin(u, to)) continue;
      // Near the minimum the gain is below the rounding of the cost.
      if (to.cost <= from.cost + 1e-4 * share * slope + 1e-16 * (1 + from.cost)) return true;
    }
    return false;
  }

  static Eigen::Matrix<double, 3, 2> TangentBasis(const Vector3d& u) {
    Eigen::Matrix<double, 3, 2> basis;
    basis.col(0) = u.unitOrthogonal();
    basis.col(1) = u.cross(basis.col(0));
    return basis;
  }

  const Polyline& curve_;
  const double scale_;
  const VectorXd lengths_, relative_;
  const std::vector<CurvePart> parts_;
  const Directions wanted_, before_;
  const MatchOptions& options_;
  const Vector3d start_, span_;

  std::vector<Eigen::Matrix<double, 3, 2>> bases_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> constraint_;
  VectorXd gradient_, curvature_;
  MatrixXd hessian_;
};

/// A chain that cannot meet both ends lies straight, its longest rod against the others if the
/// ends are too near.
ChainMatch Straight(const Polyline& curve, const VectorXd& lengths, Reach reach,
                    Unreachable policy) {
  const Vector3d start = curve.points().row(0);
  const Vector3d span = curve.points().bottomRows<1>().transpose() - start;
  const Vector3d along = span.norm() > 0 ? span.normalized() : CurveDirections(curve, lengths)[0];
  Eigen::Index longest = 0;
  lengths.maxCoeff(&longest);
  Directions directions(lengths.size(), reach == Reach::kTooFar ? along : Vector3d(-along));
  directions[longest] = along;
  double reached = 0;
  for (Eigen::Index i = 0; i < lengths.size(); ++i)
    reached += lengths[i] * along.dot(directions[i]);
  double share = 0.5;
  if (policy == Unreachable::kKeepNear) share = 0;
  if (policy == Unreachable::kKeepFar) share = 1;
  ChainMatch match =
      Measured(curve, lengths, directions, start + share * (span.norm() - reached) * along);
  match.reachable = std::abs(span.norm() - reached) <= 1e-12 * lengths.sum();
  return match;
}

Directions StartOf(const Directions& wanted, const ChainMatch* before) {
  return before ? DirectionsOf(before->directions) : wanted;
}

void RequireRows(const PointsX3& rows, const VectorXd& lengths, const char* what) {
  if (rows.rows() != lengths.size() || !rows.allFinite())
    throw InputError(std::string("armature: a chain of ") + std::to_string(lengths.size()) +
                     " rods needs as many " + what + ", all finite");
}

Directions WantedOf(const Polyline& curve, const VectorXd& lengths, const PointsX3& directions) {
  if (directions.rows() == 0) return CurveDirections(curve, lengths);
  RequireRows(directions, lengths, "directions");
  return DirectionsOf(directions);
}

}  // namespace

ChainMatch MatchBothEnds(const Polyline& curve, const VectorXd& lengths, const PointsX3& directions,
                         const ChainMatch* before, const MatchOptions& options) {
  RequireLengths(lengths);
  if (before) RequireRows(before->directions, lengths, "directions of the match before");
  const Vector3d start = curve.points().row(0);
  const Vector3d span = curve.points().bottomRows<1>().transpose() - start;
  const Reach reach = ReachOf(lengths, span.norm());
  if (reach != Reach::kReachable) return Straight(curve, lengths, reach, options.unreachable);
  const Directions wanted = WantedOf(curve, lengths, directions);
  const bool calm = before && options.calm_weight > 0;
  Search search(curve, lengths, wanted, calm ? DirectionsOf(before->directions) : Directions(),
                options);
  Place place;
  const Vector3d side = curve.At(0.5 * curve.length()) - start;
  if (!search.Begin(StartOf(wanted, before), place) && !search.Begin(wanted, place) &&
      !search.Begin(RodsOnCircle(lengths, span, side), place))
    throw SolverError("armature: a chain of " + std::to_string(lengths.size()) +
                      " rods could not be closed");
  int iterations = 0;
  const bool converged = search.Descend(place, &iterations);
  ChainMatch match = Measured(curve, lengths, place.u, start);
  match.iterations = iterations;
  match.converged = converged;
  return match;
}

double MatchCost(const Polyline& curve, const VectorXd& lengths, const PointsX3& wanted,
                 const ChainMatch* before, const MatchOptions& options,
                 const PointsX3& directions) {
  const bool calm = before && options.calm_weight > 0;
  const Search search(curve, lengths, WantedOf(curve, lengths, wanted),
                      calm ? DirectionsOf(before->directions) : Directions(), options);
  Place place;
  place.u = DirectionsOf(directions);
  search.Evaluate(place);
  return place.cost;
}

}  // namespace keypose::armature
