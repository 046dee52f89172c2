#include "export/gltf/minimax_basis.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

constexpr int kMostVertices = 4000;
// The exponent of the distances grows from 2, least squares, towards the largest distance alone.
constexpr int kSteps = 80;
constexpr double kGrowth = 1.06;
constexpr double kLargestExponent = 100;
constexpr double kSmallestMultiplier = 1e-9;  ///< relative to the largest
constexpr double kRidge = 1e-12;              ///< relative to the mean of the diagonal

/// One vertex in all pictures, P x 3.
using Path = Eigen::Matrix<double, Eigen::Dynamic, 3>;
/// The base's position and the targets' differences of one vertex, (K + 1) x 3.
using Shape = Eigen::Matrix<double, Eigen::Dynamic, 3>;

Path PathOf(const Pictures& pictures, int vertex) {
  Path path(std::ssize(pictures), 3);
  for (int p = 0; p < SizeOf(pictures); ++p) path.row(p) = pictures[p]->row(vertex);
  return path;
}

/// Weights with a first column of ones, which is the base's.
Eigen::MatrixXd WithBase(const Eigen::MatrixXd& weights) {
  Eigen::MatrixXd with_base(weights.rows(), weights.cols() + 1);
  with_base << Eigen::VectorXd::Ones(weights.rows()), weights;
  return with_base;
}

template <class Right>
Eigen::MatrixXd SolveDamped(Eigen::MatrixXd system, const Right& right) {
  system.diagonal().array() += kRidge * system.trace() / static_cast<double>(system.rows());
  return system.ldlt().solve(right);
}

Shape FitShape(const Eigen::MatrixXd& with_base, const Path& path,
               const Eigen::VectorXd& multipliers) {
  const Eigen::MatrixXd scaled = multipliers.asDiagonal() * with_base;
  return SolveDamped(with_base.transpose() * scaled, scaled.transpose() * path);
}

/// Weights of the squared distances in whose sum each counts like its power of `exponent`.
template <class Distances>
Distances Multipliers(const Distances& distances, double exponent) {
  const auto shares = distances.array() / distances.maxCoeff();
  return shares.pow(exponent - 2) + kSmallestMultiplier;
}

/// How far to go to the fit of reweighted least squares, which overshoots for exponents above 3;
/// this is Newton's step for the sum of powers.
double ShareOfStep(double exponent) { return 1 / (exponent - 1); }

/// Some vertices whose weights and shapes are fitted in turn.
class Alternation {
 public:
  Alternation(const Pictures& pictures, const std::vector<int>& vertices,
              const Eigen::MatrixXd& weights)
      : paths_(vertices.size()),
        shapes_(vertices.size(), Shape::Zero(weights.cols() + 1, 3)),
        weights_(weights),
        distances_(weights.rows(), std::ssize(vertices)),
        multipliers_(Eigen::MatrixXd::Ones(weights.rows(), std::ssize(vertices))) {
    ParallelFor(std::ssize(vertices),
                [&](std::int64_t i) { paths_[i] = PathOf(pictures, vertices[i]); });
    FitShapes(1);
    Measure();
  }

  double largest() const { return distances_.maxCoeff(); }
  const Eigen::MatrixXd& weights() const { return weights_; }

  void Step(double exponent) {
    multipliers_ = Multipliers(distances_, exponent);
    FitWeights(ShareOfStep(exponent));
    Measure();
    multipliers_ = Multipliers(distances_, exponent);
    FitShapes(ShareOfStep(exponent));
    Measure();
  }

 private:
  void FitShapes(double share) {
    const Eigen::MatrixXd with_base = WithBase(weights_);
    ParallelFor(
        std::ssize(paths_),
        [&](std::int64_t i) {
          const Shape fitted = FitShape(with_base, paths_[i], multipliers_.col(i));
          shapes_[i] += share * (fitted - shapes_[i]);
        },
        16);
  }

  void FitWeights(double share) {
    const Eigen::Index count = weights_.cols();
    ParallelFor(weights_.rows(), [&](std::int64_t p) {
      Eigen::MatrixXd system = Eigen::MatrixXd::Zero(count, count);
      Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
      for (int i = 0; i < SizeOf(paths_); ++i) {
        const auto targets = shapes_[i].bottomRows(count);
        const Eigen::Vector3d goal = (paths_[i].row(p) - shapes_[i].row(0)).transpose();
        system.noalias() += multipliers_(p, i) * (targets * targets.transpose());
        right.noalias() += multipliers_(p, i) * (targets * goal);
      }
      weights_.row(p) += share * (SolveDamped(system, right).transpose() - weights_.row(p));
    });
  }

  void Measure() {
    const Eigen::MatrixXd with_base = WithBase(weights_);
    ParallelFor(
        std::ssize(paths_),
        [&](std::int64_t i) {
          distances_.col(i) = (with_base * shapes_[i] - paths_[i]).rowwise().norm();
        },
        64);
  }

  std::vector<Path> paths_;
  std::vector<Shape> shapes_;
  Eigen::MatrixXd weights_;
  Eigen::MatrixXd distances_, multipliers_;  // P x vertices
};

/// The vertices with the largest errors, and others at even distances in their order.
std::vector<int> ChooseVertices(const Eigen::VectorXd& errors) {
  std::vector<int> vertices(errors.size());
  std::iota(vertices.begin(), vertices.end(), 0);
  if (errors.size() <= kMostVertices) return vertices;
  std::stable_sort(vertices.begin(), vertices.end(),
                   [&](int a, int b) { return errors[a] > errors[b]; });
  constexpr int kHalf = kMostVertices / 2;
  std::vector<int> chosen(vertices.begin(), vertices.begin() + kHalf);
  std::vector<int> others(vertices.begin() + kHalf, vertices.end());
  std::sort(others.begin(), others.end());
  for (std::size_t i = 0; i < kHalf; ++i) chosen.push_back(others[i * others.size() / kHalf]);
  return chosen;
}

/// The shape of a vertex with the smallest largest distance, or one where that is `enough`.
Shape MinimaxShape(const Eigen::MatrixXd& with_base, const Path& path, double enough) {
  Shape shape = FitShape(with_base, path, Eigen::VectorXd::Ones(path.rows())), best = shape;
  double smallest = std::numeric_limits<double>::infinity(), exponent = 2;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::VectorXd distances = (with_base * shape - path).rowwise().norm();
    if (distances.maxCoeff() < smallest) {
      smallest = distances.maxCoeff();
      best = shape;
    }
    if (smallest <= enough) break;
    exponent = std::min(kGrowth * exponent, kLargestExponent);
    const Shape fitted = FitShape(with_base, path, Multipliers(distances, exponent));
    shape += ShareOfStep(exponent) * (fitted - shape);
  }
  return best;
}

/// Shapes for given weights: least squares, but least maximum where that is not enough.
MorphBasis ShapesFor(const Pictures& pictures, const Eigen::MatrixXd& weights, double enough) {
  MorphBasis basis = LeastSquaresBasis(pictures, weights);
  const Eigen::VectorXd errors = VertexErrors(pictures, basis);
  const Eigen::MatrixXd with_base = WithBase(weights);
  ParallelFor(
      errors.size(),
      [&](std::int64_t v) {
        if (errors[v] <= enough) return;
        const Path path = PathOf(pictures, static_cast<int>(v));
        const Shape shape = MinimaxShape(with_base, path, enough);
        if ((with_base * shape - path).rowwise().norm().maxCoeff() >= errors[v]) return;
        basis.base.row(v) = shape.row(0);
        for (int k = 0; k < SizeOf(basis.targets); ++k) basis.targets[k].row(v) = shape.row(k + 1);
      },
      16);
  return basis;
}

}  // namespace

MorphBasis MinimaxBasis(const Pictures& pictures, MorphBasis start, double bound,
                        Progress* progress) {
  MorphBasis best = std::move(start);
  Eigen::VectorXd errors = VertexErrors(pictures, best);
  // If not all vertices take part, the second round is for those that got worse in the first.
  const int rounds = errors.size() > kMostVertices ? 2 : 1;
  for (int round = 0; round < rounds && errors.maxCoeff() > bound; ++round) {
    Alternation alternation(pictures, ChooseVertices(errors), best.weights);
    Eigen::MatrixXd weights = alternation.weights();
    double smallest = alternation.largest(), exponent = 2;
    for (int step = 0; step < kSteps && smallest > bound; ++step) {
      ReportProgress(progress, (round + static_cast<double>(step) / kSteps) / rounds,
                     "lowering the largest error of the morph targets");
      exponent = std::min(kGrowth * exponent, kLargestExponent);
      alternation.Step(exponent);
      if (alternation.largest() >= smallest) continue;
      smallest = alternation.largest();
      weights = alternation.weights();
    }
    MorphBasis fitted = ShapesFor(pictures, weights, std::max(smallest, bound));
    const Eigen::VectorXd fitted_errors = VertexErrors(pictures, fitted);
    if (fitted_errors.maxCoeff() >= errors.maxCoeff()) break;
    best = std::move(fitted);
    errors = fitted_errors;
  }
  return best;
}

}  // namespace keypose::exporting
