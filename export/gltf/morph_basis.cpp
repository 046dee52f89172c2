#include "export/gltf/morph_basis.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "export/gltf/minimax_basis.h"

namespace keypose::exporting {
namespace {

constexpr Eigen::Index kVerticesPerBlock = 512;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Scalar products of the pictures' differences to their mean. P x P
Eigen::MatrixXd CentredProducts(const Pictures& pictures) {
  const auto count = std::ssize(pictures);
  const Eigen::Index vertices = pictures[0]->rows();
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index begin = 0; begin < vertices; begin += kVerticesPerBlock) {
    const Eigen::Index rows = std::min(kVerticesPerBlock, vertices - begin);
    RowMajor block(count, 3 * rows);
    for (Eigen::Index p = 0; p < count; ++p)
      block.row(p) = pictures[p]->middleRows(begin, rows).reshaped<Eigen::RowMajor>();
    block.rowwise() -= block.colwise().mean().eval();
    products.noalias() += block * block.transpose();
  }
  return products;
}

/// Coordinates of the pictures along their principal components, strongest first, each scaled to a
/// largest value of 1.
Eigen::MatrixXd PrincipalWeights(const Eigen::MatrixXd& products, int count) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products);
  Eigen::MatrixXd weights(products.rows(), count);
  for (int k = 0; k < count; ++k) {
    const auto column = solver.eigenvectors().col(products.cols() - 1 - k);
    Eigen::Index largest = 0;
    column.cwiseAbs().maxCoeff(&largest);
    weights.col(k) = column / column(largest);  // the sign that solvers leave open is fixed too
  }
  return weights;
}

/// Fewer targets than this leave more than `bound` even on average: principal components leave the
/// least sum of squares, and the largest distance is not below the mean.
int LeastCount(const Eigen::MatrixXd& products, Eigen::Index vertices, int limit, double bound) {
  constexpr double kUnknown = 1e-12;  // of the strongest: below it nothing is known
  Eigen::VectorXd strengths =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(products, Eigen::EigenvaluesOnly)
          .eigenvalues();  // ascending
  const double least = kUnknown * strengths.maxCoeff();
  for (double& strength : strengths) strength = strength > least ? strength : 0;
  const double allowed = bound * bound * static_cast<double>(products.rows() * vertices);
  int count = limit;
  double left = strengths.head(products.rows() - limit).sum();
  while (count > 1 && left + strengths(products.rows() - count) <= allowed)
    left += strengths(products.rows() - count--);
  return count;
}

/// Weights of all pictures as sums of the chosen ones, relative to picture 0.
Eigen::MatrixXd WeightsOfChosen(const Eigen::MatrixXd& products, const std::vector<int>& chosen) {
  // Scalar products of the differences to picture 0.
  Eigen::MatrixXd from_first = products;
  from_first.rowwise() -= products.row(0);
  from_first.colwise() -= from_first.col(0).eval();
  const Eigen::MatrixXd among = from_first(chosen, chosen), to_all = from_first(chosen, Eigen::all);
  Eigen::MatrixXd weights = among.colPivHouseholderQr().solve(to_all).transpose();
  weights.row(0).setZero();
  for (int k = 0; k < SizeOf(chosen); ++k) weights.row(chosen[k]).setZero();
  for (int k = 0; k < SizeOf(chosen); ++k) weights(chosen[k], k) = 1;
  return weights;
}

MorphBasis BasisOfChosen(const Pictures& pictures, const Eigen::MatrixXd& products,
                         const std::vector<int>& chosen) {
  MorphBasis basis{*pictures[0], {}, WeightsOfChosen(products, chosen)};
  for (const int p : chosen) basis.targets.push_back(*pictures[p] - *pictures[0]);
  return basis;
}

/// The picture that the basis gives worst.
int WorstPicture(const Pictures& pictures, const MorphBasis& basis) {
  std::vector<double> errors(pictures.size());
  ParallelFor(std::ssize(pictures), [&](std::int64_t p) {
    errors[p] = (Blended(basis, p) - *pictures[p]).rowwise().squaredNorm().maxCoeff();
  });
  return static_cast<int>(std::max_element(errors.begin(), errors.end()) - errors.begin());
}

MorphBasis GreedyBasis(const Pictures& pictures, const Eigen::MatrixXd& products, int count) {
  MorphBasis basis{*pictures[0], {}, Eigen::MatrixXd::Zero(std::ssize(pictures), 0)};
  std::vector<int> chosen;
  while (SizeOf(chosen) < count) {
    const int worst = WorstPicture(pictures, basis);
    if (worst == 0 || std::count(chosen.begin(), chosen.end(), worst)) break;
    chosen.push_back(worst);
    basis = BasisOfChosen(pictures, products, chosen);
  }
  return basis;
}

}  // namespace

MorphFit FitMorphBasis(const Pictures& pictures, int max_targets, double bound,
                       Progress* progress) {
  // Minimising the largest error gains about a factor of two over principal components.
  constexpr double kLargestGain = 3;
  const int limit = std::min(max_targets, SizeOf(pictures) - 1);
  const Eigen::MatrixXd products = CentredProducts(pictures);
  const Eigen::MatrixXd principal = PrincipalWeights(products, limit);
  MorphFit fit;
  fit.largest_error = std::numeric_limits<double>::infinity();
  int count = LeastCount(products, pictures[0]->rows(), limit, bound) - 1;
  while (fit.largest_error > bound && count < limit) {
    ++count;
    SubProgress part(progress, static_cast<double>(count - 1) / limit,
                     static_cast<double>(count) / limit);
    ReportProgress(&part, 0, "fitting morph targets");
    fit.basis = LeastSquaresBasis(pictures, principal.leftCols(count));
    fit.largest_error = VertexErrors(pictures, fit.basis).maxCoeff();
    const bool promising = fit.largest_error <= kLargestGain * bound || count == limit;
    if (fit.largest_error <= bound || !promising) continue;
    fit.basis = MinimaxBasis(pictures, std::move(fit.basis), bound, &part);
    fit.largest_error = VertexErrors(pictures, fit.basis).maxCoeff();
  }
  MorphBasis greedy = GreedyBasis(pictures, products, count);
  fit.error_of_pictures = VertexErrors(pictures, greedy).maxCoeff();
  if (fit.error_of_pictures < fit.largest_error) {
    fit.basis = std::move(greedy);
    fit.largest_error = fit.error_of_pictures;
  }
  return fit;
}

}  // namespace keypose::exporting
