#include "register/intrinsic/spectral.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/numbers/cholesky.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "deform/solvers/dense_product.h"

namespace keypose::registration {

namespace {

// Lower bound: obtuse corners would give negative weights and unusable eigenfunctions.
constexpr double kLeastCotangent = 0.02;
// Below the first nonzero eigenvalue of shapes of unit area (about 10), but not so small that the
// constant function dominates.
constexpr double kShift = 1;

struct Operator {
  Eigen::SparseMatrix<double> shifted;  ///< L + shift * diag(areas), lower triangle
  Eigen::VectorXd areas;
};

Operator MakeOperator(const PointsX3& points, const FacesX3& faces) {
  const Eigen::Index n = points.rows();
  Operator op;
  op.areas = Eigen::VectorXd::Zero(n);
  const Eigen::VectorXd face_areas = FaceAreas(points, faces);
  const double total = face_areas.sum();
  if (!(total > 0)) throw InputError("register: the surface has no area");
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(9 * faces.rows() + n));
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      op.areas[faces(f, k)] += face_areas[f] / (3 * total);
      const int i = faces(f, k), j = faces(f, (k + 1) % 3), o = faces(f, (k + 2) % 3);
      if (i == j) continue;
      const Eigen::RowVector3d u = points.row(i) - points.row(o), v = points.row(j) - points.row(o);
      const double cross = u.cross(v).norm(), dot = u.dot(v);
      const double cotangent =
          cross > 0 ? std::clamp(dot / cross, kLeastCotangent, 50.0) : kLeastCotangent;
      entries.emplace_back(std::max(i, j), std::min(i, j), -0.5 * cotangent);
      diagonal[i] += 0.5 * cotangent;
      diagonal[j] += 0.5 * cotangent;
    }
  }
  const double least = 1e-3 / static_cast<double>(n);  // vertices without faces
  for (Eigen::Index i = 0; i < n; ++i) {
    op.areas[i] = std::max(op.areas[i], least);
    entries.emplace_back(i, i, 0.0);
  }
  op.areas /= op.areas.sum();
  for (Eigen::Index i = 0; i < n; ++i)
    entries.emplace_back(i, i, diagonal[i] + kShift * op.areas[i]);
  op.shifted.resize(n, n);
  op.shifted.setFromTriplets(entries.begin(), entries.end());
  return op;
}

/// Krylov space of a symmetric operator: orthonormal columns Q and Q^T B Q.
struct Krylov {
  Eigen::MatrixXd basis, projected;
};

/// Fixed pseudo-random start vectors. They have no symmetry, so no eigenfunction is orthogonal to
/// all of them.
class StartVectors {
 public:
  Eigen::VectorXd Next(Eigen::Index n) {
    Eigen::VectorXd vector(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
      vector[i] = static_cast<double>(state_ >> 11) * 0x1.0p-53 - 0.5;
    }
    return vector;
  }

 private:
  std::uint64_t state_ = 0x9E3779B97F4A7C15ull;
};

/// Subtracts from the columns of `block` their projection on the orthonormal `basis`.
/// @return the coordinates of the projection
Eigen::MatrixXd TakeOut(const Eigen::Ref<const Eigen::MatrixXd>& basis, Eigen::MatrixXd& block) {
  Eigen::MatrixXd within(basis.cols(), block.cols());
  if (basis.cols() == 0) return within;
  Multiply(1.0, basis, block, Flip::kFirst, 0, within);
  Multiply(-1.0, basis, within, Flip::kNone, 1, block);
  return within;
}

/// Orthonormalises the columns of `block` and appends them to the first `filled` columns of the
/// basis. A column that vanishes is replaced by a start vector.
void Append(Eigen::MatrixXd block, Eigen::MatrixXd& basis, Eigen::Index& filled,
            StartVectors& starts) {
  const Eigen::VectorXd before = block.colwise().norm();
  for (int twice = 0; twice < 2; ++twice) TakeOut(basis.leftCols(filled), block);
  const Eigen::Index old = filled;
  for (Eigen::Index c = 0; c < block.cols(); ++c, ++filled) {
    Eigen::VectorXd vector = block.col(c);
    double length = before[c];
    // `block` is already orthogonal to the old basis. What remains are the columns of this block.
    // A replacement must be made orthogonal to all.
    for (Eigen::Index first = old;; first = 0) {
      for (int twice = 0; twice < 2; ++twice)
        vector -= basis.middleCols(first, filled - first) *
                  (basis.middleCols(first, filled - first).transpose() * vector);
      const double after = vector.norm();
      if (after > 1e-10 * length && after > 1e-14) {
        basis.col(filled) = vector / after;
        break;
      }
      vector = starts.Next(basis.rows());
      length = vector.norm();
    }
  }
}

/// Block Lanczos. A block of vectors finds the repeated eigenvalues of symmetric shapes, which a
/// single vector would miss.
template <class Apply>
Krylov BlockLanczos(const Apply& apply, Eigen::Index n, Eigen::Index size) {
  constexpr Eigen::Index kBlock = 4;
  Krylov k{Eigen::MatrixXd(n, size), Eigen::MatrixXd::Zero(size, size)};
  StartVectors starts;
  Eigen::Index filled = 0;
  Eigen::MatrixXd w(n, std::min(kBlock, size));
  for (Eigen::Index c = 0; c < w.cols(); ++c) w.col(c) = starts.Next(n);
  Append(w, k.basis, filled, starts);
  for (Eigen::Index done = 0; done < size;) {
    const Eigen::Index block = std::min(kBlock, filled - done);
    w = apply(k.basis.middleCols(done, block));
    k.projected.block(0, done, filled, block) = TakeOut(k.basis.leftCols(filled), w);
    done += block;
    const Eigen::Index before = filled;
    Append(w.leftCols(std::min(block, size - filled)), k.basis, filled, starts);
    k.projected.block(before, done - block, filled - before, block) =
        k.basis.middleCols(before, filled - before).transpose() * w;
  }
  // Only the upper triangle was computed with all vectors present. The matrix is symmetric up to
  // rounding, so the upper triangle is mirrored.
  const Eigen::MatrixXd upper = k.projected.triangularView<Eigen::Upper>();
  k.projected = upper + upper.transpose();
  k.projected.diagonal() = upper.diagonal();
  return k;
}

}  // namespace

Spectrum LaplaceSpectrum(const PointsX3& points, const FacesX3& faces, int count) {
  const Eigen::Index n = points.rows();
  const Operator op = MakeOperator(points, faces);
  const Eigen::VectorXd root = op.areas.cwiseSqrt();
  SparseCholesky cholesky;
  cholesky.Analyze(op.shifted);
  cholesky.Factor(op.shifted);
  const auto apply = [&](const Eigen::MatrixXd& x) -> Eigen::MatrixXd {
    return root.asDiagonal() * cholesky.Solve(root.asDiagonal() * x);
  };
  const Eigen::Index wanted = std::min<Eigen::Index>(count, n - 1),
                     steps = std::min<Eigen::Index>(n, 2 * wanted + 60);
  const Krylov krylov = BlockLanczos(apply, n, steps);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(krylov.projected);
  Spectrum spectrum;
  spectrum.areas = op.areas;
  spectrum.values.resize(wanted);
  const Eigen::MatrixXd largest = ritz.eigenvectors().rightCols(wanted).rowwise().reverse();
  spectrum.functions.resize(n, wanted);
  Multiply(1.0, krylov.basis, largest, Flip::kNone, 0, spectrum.functions);
  spectrum.functions = root.cwiseInverse().asDiagonal() * spectrum.functions;
  for (Eigen::Index k = 0; k < wanted; ++k) {
    spectrum.values[k] = 1 / std::max(ritz.eigenvalues()[steps - 1 - k], 1e-300) - kShift;
    Eigen::Index at = 0;
    spectrum.functions.col(k).cwiseAbs().maxCoeff(&at);
    if (spectrum.functions(at, k) < 0) spectrum.functions.col(k) *= -1;
  }
  return spectrum;
}

}  // namespace keypose::registration
