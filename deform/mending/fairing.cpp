#include "deform/mending/fairing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/numbers/cholesky.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

using Eigen::SparseMatrix;
using Eigen::Vector3d;
using Triplets = std::vector<Eigen::Triplet<double>>;

// Slivers would weigh without bound.
constexpr double kLeastCotangent = 0.05, kMostCotangent = 20;
// How often the plate is bent anew by the shape that it took: a bite's walls say nothing of the
// patch.
constexpr int kRounds = 4;

/// The free vertices, the ring round them, and the ring round that, which only holds.
struct Patch {
  Patch(const MeshRings& rings, const std::vector<int>& free) : local(rings.faces.size(), -1) {
    const auto add = [&](int vertex) {
      if (local[vertex] >= 0) return;
      local[vertex] = static_cast<int>(vertices.size());
      vertices.push_back(vertex);
    };
    for (const int vertex : free) add(vertex);
    free_count = static_cast<int>(vertices.size());
    for (int i = 0; i < free_count; ++i)
      for (const int next : rings.neighbours[vertices[i]]) add(next);
    row_count = static_cast<int>(vertices.size());
    for (int i = free_count; i < row_count; ++i)
      for (const int next : rings.neighbours[vertices[i]]) add(next);
  }
  int size() const { return static_cast<int>(vertices.size()); }

  std::vector<int> vertices;  ///< of the mesh
  std::vector<int> local;     ///< of each vertex of the mesh; -1: outside
  int free_count = 0;         ///< of `vertices`, the first
  int row_count = 0;          ///< those with a row of the Laplacian: the free ones and their ring
};

enum class Weights { kUniform, kCotangent };

double Cotangent(const Vector3d& u, const Vector3d& v) {
  const double sine = u.cross(v).norm();
  const double cotangent = sine > 0 ? u.dot(v) / sine : kMostCotangent;
  return std::clamp(cotangent, kLeastCotangent, kMostCotangent);
}

/// The Laplacian's rows over the root of each vertex's area, so that the sum of their squares is
/// the energy; and the areas. Source: Botsch & Kobbelt 2004, "An intuitive framework for real-time
/// freeform modeling".
struct Laplacian {
  SparseMatrix<double> rows;
  Eigen::VectorXd areas;  ///< of the rows' vertices
};

Laplacian LaplacianOf(const Mesh& mesh, const MeshRings& rings, const Patch& patch,
                      const PointsX3& at, Weights weights) {
  Laplacian laplacian;
  laplacian.areas = Eigen::VectorXd::Zero(patch.row_count);
  Triplets triplets;
  const auto corner = [&](int face, int k) -> Vector3d {
    return at.row(patch.local[mesh.faces(face, k)]);
  };
  for (int i = 0; i < patch.row_count; ++i) {
    for (const int face : rings.faces[patch.vertices[i]]) {
      int k = 0;
      while (mesh.faces(face, k) != patch.vertices[i]) ++k;
      const Vector3d here = corner(face, k);
      const Vector3d next = corner(face, (k + 1) % 3), last = corner(face, (k + 2) % 3);
      laplacian.areas[i] += (next - here).cross(last - here).norm() / 6;
      const bool uniform = weights == Weights::kUniform;
      // The angle at each of the two other corners weighs the edge to the third.
      const double to_last = uniform ? 1 : Cotangent(here - next, last - next) / 2;
      const double to_next = uniform ? 1 : Cotangent(here - last, next - last) / 2;
      triplets.emplace_back(i, patch.local[mesh.faces(face, (k + 1) % 3)], to_next);
      triplets.emplace_back(i, patch.local[mesh.faces(face, (k + 2) % 3)], to_last);
      triplets.emplace_back(i, i, -to_next - to_last);
    }
  }
  // A vertex whose faces have no area would weigh without bound.
  const double least = 1e-3 * laplacian.areas.mean();
  laplacian.areas = laplacian.areas.cwiseMax(std::max(least, 1e-300));
  const Eigen::VectorXd scale = weights == Weights::kUniform
                                    ? Eigen::VectorXd::Ones(patch.row_count).eval()
                                    : laplacian.areas.cwiseSqrt().cwiseInverse().eval();
  laplacian.rows.resize(patch.row_count, patch.size());
  laplacian.rows.setFromTriplets(triplets.begin(), triplets.end());
  laplacian.rows = (scale.asDiagonal() * laplacian.rows).eval();
  return laplacian;
}

PointsX3 PlacesOf(const Patch& patch, const PointsX3& points) {
  PointsX3 at(patch.size(), 3);
  for (int i = 0; i < patch.size(); ++i) at.row(i) = points.row(patch.vertices[i]);
  return at;
}

/// The minimum of `bending` |L x|^2 + sum of pull_i |x_i - at_i|^2 over the free vertices.
PointsX3 Solved(const Patch& patch, const PointsX3& at, const Laplacian& laplacian, double bending,
                const Eigen::VectorXd& pull) {
  const int n = patch.free_count;
  const SparseMatrix<double> free = laplacian.rows.leftCols(n);
  const SparseMatrix<double> held = laplacian.rows.rightCols(patch.size() - n);
  SparseMatrix<double> matrix = bending * (SparseMatrix<double>(free.transpose()) * free);
  Eigen::MatrixXd right =
      -bending * (free.transpose() * (held * at.bottomRows(patch.size() - n).eval()));
  right += pull.asDiagonal() * at.topRows(n);
  for (int i = 0; i < n; ++i) matrix.coeffRef(i, i) += pull[i];
  matrix.makeCompressed();
  SparseCholesky solver;
  solver.Analyze(matrix);
  solver.Factor(matrix);
  return solver.Solve(right);
}

void RequireHeld(const Patch& patch) {
  if (patch.size() == patch.free_count)
    throw InputError("the brush covers a whole piece of the mesh, so no rim is left");
}

}  // namespace

PointsX3 ThinPlate(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
                   const std::vector<int>& free) {
  const Patch patch(rings, free);
  RequireHeld(patch);
  PointsX3 at = PlacesOf(patch, points);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(patch.free_count);
  for (int round = 0; round < kRounds; ++round) {
    const Weights weights = round == 0 ? Weights::kUniform : Weights::kCotangent;
    const Laplacian laplacian = LaplacianOf(mesh, rings, patch, at, weights);
    // The unit of the energy does not matter; near 1 the factor is sure to be positive.
    const double size = laplacian.rows.squaredNorm() / std::max(1, patch.row_count);
    at.topRows(patch.free_count) = Solved(patch, at, laplacian, 1 / size, none);
  }
  return at.topRows(patch.free_count);
}

PointsX3 Faded(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
               const std::vector<int>& free, double width) {
  const Patch patch(rings, free);
  const PointsX3 at = PlacesOf(patch, points);
  const Laplacian laplacian = LaplacianOf(mesh, rings, patch, at, Weights::kCotangent);
  const Eigen::VectorXd areas = laplacian.areas.head(patch.free_count);
  const double unit = areas.mean();
  const double bending = std::pow(width / 4, 4) / unit;
  return Solved(patch, at, laplacian, bending, areas / unit);
}

}  // namespace keypose
