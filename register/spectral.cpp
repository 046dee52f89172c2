#include "register/spectral.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/cholesky.h"
#include "core/errors.h"
#include "core/geometry.h"

namespace keypose::registration {

namespace {

constexpr double kLeastCotangent = 0.02;  // slivers and obtuse corners would make weights negative, and functions wild
constexpr double kShift = 1;              // below the first eigenvalue of unit-area shapes (about 10), so that constants do not dominate

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
      const double cotangent = cross > 0 ? std::clamp(dot / cross, kLeastCotangent, 50.0) : kLeastCotangent;
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
  for (Eigen::Index i = 0; i < n; ++i) entries.emplace_back(i, i, diagonal[i] + kShift * op.areas[i]);
  op.shifted.resize(n, n);
  op.shifted.setFromTriplets(entries.begin(), entries.end());
  return op;
}

/// Krylov space of a symmetric operator: orthonormal columns Q and the tridiagonal T = Q^T B Q.
struct Krylov {
  Eigen::MatrixXd basis;
  Eigen::VectorXd diagonal, off_diagonal;
};

/// A fixed start without symmetry, so that no eigenfunction is missed for being orthogonal to it.
Eigen::VectorXd StartVector(Eigen::Index n) {
  Eigen::VectorXd start(n);
  std::uint64_t state = 0x9E3779B97F4A7C15ull;
  for (Eigen::Index i = 0; i < n; ++i) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    start[i] = static_cast<double>(state >> 11) * 0x1.0p-53 - 0.5;
  }
  return start;
}

template <class Apply>
Krylov Lanczos(const Apply& apply, Eigen::Index n, Eigen::Index steps) {
  Krylov k{Eigen::MatrixXd(n, steps), Eigen::VectorXd::Zero(steps), Eigen::VectorXd::Zero(std::max<Eigen::Index>(steps - 1, 0))};
  k.basis.col(0) = StartVector(n).normalized();
  for (Eigen::Index j = 0; j < steps; ++j) {
    Eigen::VectorXd w = apply(k.basis.col(j));
    k.diagonal[j] = w.dot(k.basis.col(j));
    const auto before = k.basis.leftCols(j + 1);
    for (int twice = 0; twice < 2; ++twice) w.noalias() -= before * (before.transpose() * w);
    if (j + 1 == steps) break;
    k.off_diagonal[j] = w.norm();
    if (k.off_diagonal[j] < 1e-13) {  // the space is invariant: go on with what is orthogonal to it
      k.off_diagonal[j] = 0;
      w = StartVector(n).reverse();
      for (int twice = 0; twice < 2; ++twice) w.noalias() -= before * (before.transpose() * w);
    }
    k.basis.col(j + 1) = w.normalized();
  }
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
  const auto apply = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return root.cwiseProduct(Eigen::VectorXd(cholesky.Solve(root.cwiseProduct(x))));
  };
  const Eigen::Index wanted = std::min<Eigen::Index>(count, n - 1), steps = std::min<Eigen::Index>(n, 2 * wanted + 40);
  const Krylov krylov = Lanczos(apply, n, steps);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
  ritz.computeFromTridiagonal(krylov.diagonal, krylov.off_diagonal);
  Spectrum spectrum;
  spectrum.areas = op.areas;
  spectrum.values.resize(wanted);
  const Eigen::MatrixXd largest = ritz.eigenvectors().rightCols(wanted).rowwise().reverse();
  spectrum.functions = root.cwiseInverse().asDiagonal() * (krylov.basis * largest);
  for (Eigen::Index k = 0; k < wanted; ++k) {
    spectrum.values[k] = 1 / std::max(ritz.eigenvalues()[steps - 1 - k], 1e-300) - kShift;
    Eigen::Index at = 0;
    spectrum.functions.col(k).cwiseAbs().maxCoeff(&at);
    if (spectrum.functions(at, k) < 0) spectrum.functions.col(k) *= -1;
  }
  return spectrum;
}

}  // namespace keypose::registration
