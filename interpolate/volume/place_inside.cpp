#include "interpolate/volume/place_inside.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/cholesky.h"
#include "core/numbers/parallel.h"
#include "core/values/tuned.h"

namespace keypose::interpolation {

namespace {

constexpr int kRounds = 100;
// largest move of a round over the mean edge of a tetrahedron, at convergence
constexpr double kSettledMove = 1e-4;
constexpr int kSweeps = 40;

// No record of the data; sensitivity: docs/results/sensitivity.md.
struct UntanglingTuning {
  // tetrahedra below this determinant over the body's own growth are untangled
  KEYPOSE_TUNED(double, kNearlyFlat, 0.01);
};

/// Orthonormal frame of a triangle: along its first edge, across, and its normal.
Eigen::Matrix3d FrameOf(const PointsX3& p, const FacesX3& faces, Eigen::Index f) {
  const Eigen::Vector3d a = p.row(faces(f, 1)) - p.row(faces(f, 0)),
                        b = p.row(faces(f, 2)) - p.row(faces(f, 0));
  Eigen::Matrix3d edges;
  edges << a, b, a.cross(b).normalized();
  return edges;
}

/// Rotation of each vertex: the nearest to the mean of its faces' maps with unit growth along the
/// normal. V x 9, matrices as rows.
Eigen::MatrixXd SurfaceTurns(const PointsX3& from, const PointsX3& to, const FacesX3& faces,
                             Eigen::Index vertex_count) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(vertex_count, 9);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Eigen::Matrix3d start = FrameOf(from, faces, f), end = FrameOf(to, faces, f);
    Eigen::Matrix3d turn = ClosestRotation(end * start.inverse());
    if (!turn.allFinite()) continue;  // a face without area
    turn *= std::abs(start.determinant());
    for (int k = 0; k < 3; ++k)
      sums.row(faces(f, k)) += Eigen::Map<const Eigen::RowVectorXd>(turn.data(), 9);
  }
  for (Eigen::Index i = 0; i < vertex_count; ++i) {
    const Eigen::RowVectorXd row = sums.row(i);
    const Eigen::Matrix3d mean = Eigen::Map<const Eigen::Matrix3d>(row.data());
    const Eigen::Matrix3d turn =
        mean.norm() > 0 ? ClosestRotation(mean) : Eigen::Matrix3d::Identity();
    sums.row(i) = Eigen::Map<const Eigen::RowVectorXd>(turn.data(), 9);
  }
  return sums;
}

/// Solves a Laplacian for the inner points, with the surface's values given.
class InnerSolver {
 public:
  InnerSolver(const Solid& solid, const std::vector<TetShape>& shapes, Eigen::Index surface_count)
      : v_(surface_count), n_(solid.points.rows()) {
    const Eigen::SparseMatrix<double> lower =
        LaplacianOf(n_, solid.tets, shapes, [&](std::int64_t t) -> Eigen::Matrix3d {
          return shapes[t].volume * Eigen::Matrix3d::Identity();
        });
    coupling_ = lower.bottomLeftCorner(n_ - v_, v_);
    const Eigen::SparseMatrix<double> inner = lower.bottomRightCorner(n_ - v_, n_ - v_);
    solver_.Analyze(inner);
    solver_.Factor(inner);
  }
  /// @param rhs  N x C; only the inner rows are used
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd& surface) const {
    return solver_.Solve(rhs.bottomRows(n_ - v_) - coupling_ * surface);
  }

 private:
  Eigen::Index v_, n_;
  Eigen::SparseMatrix<double> coupling_;
  SparseCholesky solver_;
};

std::vector<Eigen::Matrix3d> FirstTurns(const Solid& solid, const InnerSolver& solver,
                                        const FacesX3& faces, const PointsX3& surface) {
  const Eigen::Index v = surface.rows(), n = solid.points.rows();
  Eigen::MatrixXd field(n, 9);
  field.topRows(v) = SurfaceTurns(solid.points.topRows(v), surface, faces, v);
  field.bottomRows(n - v) = solver.Solve(Eigen::MatrixXd::Zero(n, 9), field.topRows(v));
  std::vector<Eigen::Matrix3d> turns(solid.tets.rows());
  ParallelFor(
      solid.tets.rows(),
      [&](std::int64_t t) {
        Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(9);
        for (int k = 0; k < 4; ++k) sum += field.row(solid.tets(t, k));
        turns[t] = ClosestRotation(Eigen::Map<const Eigen::Matrix3d>(sum.data()));
      },
      256);
  return turns;
}

/// Energy of a tetrahedron's map, with its derivatives with respect to one corner. Garanzha et al.,
/// Eq. 3, theta = 1/2.
class FoldEnergy {
 public:
  explicit FoldEnergy(double epsilon) : epsilon_(epsilon) {}
  double Value(const Eigen::Matrix3d& j) const {
    const double d = j.determinant(), chi = Chi(d);
    return j.squaredNorm() / std::pow(chi, 2.0 / 3) + (d * d + 1) / chi;
  }
  /// Adds gradient and Hessian for a corner with hat gradient g. The map is J + x g^T, whose
  /// determinant is linear in x.
  void Add(const Eigen::Matrix3d& j, const Eigen::Vector3d& g, double weight,
           Eigen::Vector3d& gradient, Eigen::Matrix3d& hessian) const {
    Eigen::Matrix3d cofactors;
    cofactors << j.col(1).cross(j.col(2)), j.col(2).cross(j.col(0)), j.col(0).cross(j.col(1));
    const double d = j.col(0).dot(cofactors.col(0)), root = std::hypot(epsilon_, d), chi = Chi(d),
                 q = j.squaredNorm();
    const double c1 = 0.5 * (1 + d / root), c2 = 0.5 * epsilon_ * epsilon_ / (root * root * root);
    const double p = std::pow(chi, -2.0 / 3), p1 = -2.0 / 3 * p / chi * c1,
                 p2 = 10.0 / 9 * p / (chi * chi) * c1 * c1 - 2.0 / 3 * p / chi * c2;
    const double r = d * d + 1, s1 = 2 * d / chi - r * c1 / (chi * chi);
    const double s2 = 2 / chi - 4 * d * c1 / (chi * chi) +
                      r * (2 * c1 * c1 / (chi * chi * chi) - c2 / (chi * chi));
    const Eigen::Vector3d c = cofactors * g, e = 2 * (j * g);
    gradient += weight * (p * e + (q * p1 + s1) * c);
    hessian +=
        weight * (2 * g.squaredNorm() * p * Eigen::Matrix3d::Identity() +
                  p1 * (e * c.transpose() + c * e.transpose()) + (q * p2 + s2) * c * c.transpose());
  }

 private:
  /// Positive for all d, and close to d where d is well above epsilon.
  double Chi(double d) const {
    const double root = std::hypot(epsilon_, d);
    return d > 0 ? 0.5 * (d + root) : 0.5 * epsilon_ * epsilon_ / (root - d);
  }
  double epsilon_;
};

/// Moves single points so that the tetrahedra around them are no longer inverted.
class PointUntangler {
 public:
  PointUntangler(const Solid& solid, const std::vector<TetShape>& shapes, Eigen::Index fixed,
                 PointsX3& points)
      : solid_(solid), shapes_(shapes), fixed_(fixed), points_(points), star_(solid.points.rows()) {
    for (Eigen::Index t = 0; t < solid.tets.rows(); ++t)
      for (int k = 0; k < 4; ++k) star_[solid.tets(t, k)].push_back(static_cast<int>(t));
    double before = 0, after = 0;
    for (Eigen::Index t = 0; t < solid.tets.rows(); ++t) {
      before += shapes[t].volume;
      after += shapes[t].volume * MapOf(shapes[t], points, solid.tets, t).determinant();
    }
    shrink_ = after > 0 ? std::cbrt(before / after) : 1;
  }

  Eigen::Matrix3d Map(Eigen::Index t) const {
    return shrink_ * MapOf(shapes_[t], points_, solid_.tets, t);
  }

  std::vector<int> FoldedTets(double least) const {
    std::vector<int> folded;
    for (Eigen::Index t = 0; t < solid_.tets.rows(); ++t)
      if (!(Map(t).determinant() > least)) folded.push_back(static_cast<int>(t));
    return folded;
  }

  /// Inner points of these tetrahedra and of their neighbours, in rising order.
  std::vector<int> PointsAround(const std::vector<int>& tets) const {
    std::vector<char> wanted(star_.size(), 0);
    for (int t : tets)
      for (int k = 0; k < 4; ++k)
        for (int near : star_[solid_.tets(t, k)])
          for (int m = 0; m < 4; ++m) wanted[solid_.tets(near, m)] = 1;
    std::vector<int> points;
    for (Eigen::Index i = fixed_; i < std::ssize(star_); ++i)
      if (wanted[i]) points.push_back(static_cast<int>(i));
    return points;
  }

  void Move(int i, const FoldEnergy& energy) {
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    for (int t : star_[i])
      energy.Add(Map(t), shrink_ * HatGradient(t, i), shapes_[t].volume, gradient, hessian);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(hessian);
    const Eigen::Vector3d values =
        eigen.eigenvalues().cwiseAbs().cwiseMax(1e-9 * eigen.eigenvalues().cwiseAbs().maxCoeff());
    const Eigen::Vector3d step = -(
        eigen.eigenvectors() * (eigen.eigenvectors().transpose() * gradient).cwiseQuotient(values));
    if (!step.allFinite()) return;
    const Eigen::RowVector3d start = points_.row(i);
    const double before = StarValue(i, energy);
    for (double length = 1; length > 1e-4; length *= 0.5) {
      points_.row(i) = start + length * step.transpose();
      if (StarValue(i, energy) < before) return;
    }
    points_.row(i) = start;
  }

 private:
  Eigen::Vector3d HatGradient(int t, int i) const {
    for (int k = 0; k < 3; ++k)
      if (solid_.tets(t, k) == i) return shapes_[t].gradients.col(k);
    return shapes_[t].gradients.col(3);
  }
  double StarValue(int i, const FoldEnergy& energy) const {
    double sum = 0;
    for (int t : star_[i]) sum += shapes_[t].volume * energy.Value(Map(t));
    return sum;
  }

  const Solid& solid_;
  const std::vector<TetShape>& shapes_;
  Eigen::Index fixed_;
  PointsX3& points_;
  std::vector<std::vector<int>> star_;
  double shrink_ = 1;
};

}  // namespace

int Untangle(const Solid& solid, const std::vector<TetShape>& shapes, Eigen::Index fixed,
             PointsX3& points) {
  PointUntangler untangler(solid, shapes, fixed, points);
  std::vector<int> folded = untangler.FoldedTets(UntanglingTuning::kNearlyFlat);
  for (int sweep = 0; sweep < kSweeps && !folded.empty(); ++sweep) {
    double least = 1;
    for (int t : folded) least = std::min(least, untangler.Map(t).determinant());
    // Garanzha's rule for epsilon, from the smallest determinant.
    const FoldEnergy energy(std::sqrt(1e-8 + 0.04 * std::min(0.0, least) * std::min(0.0, least)));
    for (int i : untangler.PointsAround(folded)) untangler.Move(i, energy);
    folded = untangler.FoldedTets(UntanglingTuning::kNearlyFlat);
  }
  return static_cast<int>(untangler.FoldedTets(0).size());
}

PointsX3 PlaceInside(const Solid& solid, const std::vector<TetShape>& shapes, const FacesX3& faces,
                     const PointsX3& surface) {
  const Eigen::Index v = surface.rows(), n = solid.points.rows();
  PointsX3 points(n, 3);
  points.topRows(v) = surface;
  if (n == v) return points;
  const InnerSolver solver(solid, shapes, v);
  const CornerSums sums(n, solid.tets);
  std::vector<Eigen::Matrix3d> turns = FirstTurns(solid, solver, faces, surface);
  double mean_volume = 0;
  for (const TetShape& shape : shapes)
    mean_volume += shape.volume / static_cast<double>(shapes.size());
  const double settled = kSettledMove * std::cbrt(8.5 * mean_volume);
  for (int round = 0; round < kRounds; ++round) {
    const PointsX3 rhs = sums.Sum([&](std::int64_t t, Eigen::Matrix<double, 3, 4>& corners) {
      if (round > 0) turns[t] = ClosestRotation(MapOf(shapes[t], points, solid.tets, t));
      corners = shapes[t].volume * (turns[t] * shapes[t].gradients);
    });
    const PointsX3 inner = solver.Solve(rhs, surface);
    const double move =
        round > 0 ? (inner - points.bottomRows(n - v)).rowwise().norm().maxCoeff() : settled + 1;
    points.bottomRows(n - v) = inner;
    if (move <= settled) break;
  }
  Untangle(solid, shapes, v, points);
  return points;
}

}  // namespace keypose::interpolation
