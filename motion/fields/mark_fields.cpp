#include "motion/fields/mark_fields.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"
#include "deform/solvers/block_cholesky.h"

namespace keypose::motion {

namespace {

constexpr int kColumns = 48;         // right-hand sides that are solved together
constexpr double kSliver = 1e-6;     // as in deform/poisson
constexpr double kLeastEdge = 1e-4;  // weight of an edge whose cotangents sum to less

using Row = std::vector<std::pair<int, double>>;

/// Drops small weights and makes the rest sum to 1.
Row Kept(Row row, double least) {
  std::erase_if(row, [&](const auto& term) { return !(std::abs(term.second) >= least); });
  double sum = 0;
  for (const auto& term : row) sum += term.second;
  if (sum != 0)
    for (auto& term : row) term.second /= sum;
  return row;
}

struct Edge {
  int a, b;  // a < b
  double weight;
};

/// All edges with the sums of their faces' weights, in a fixed order.
std::vector<Edge> EdgesOf(const PointsX3& points, const FacesX3& faces) {
  std::vector<Edge> sides;
  sides.reserve(faces.size());
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d w = HalfCotangents(points, faces, f);
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, (k + 1) % 3), b = faces(f, (k + 2) % 3);
      if (a != b) sides.push_back({std::min(a, b), std::max(a, b), w[k]});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Edge& x, const Edge& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  std::vector<Edge> edges;
  for (const Edge& side : sides)
    if (!edges.empty() && edges.back().a == side.a && edges.back().b == side.b)
      edges.back().weight += side.weight;
    else
      edges.push_back(side);
  return edges;
}

/// The Laplacian of the vertices that no mark fixes, and how the fixed ones act on them.
class FreeLaplacian {
 public:
  FreeLaplacian(const PointsX3& points, const FacesX3& faces, const std::vector<char>& fixed,
                bool bounded)
      : place_(points.rows(), -1) {
    for (int i = 0; i < SizeOf(fixed); ++i)
      if (!fixed[i]) {
        place_[i] = SizeOf(vertices_);
        vertices_.push_back(i);
      }
    std::vector<Eigen::Triplet<double>> entries;
    std::vector<double> diagonal(vertices_.size(), 0);
    for (const Edge& edge : EdgesOf(points, faces)) {
      const double w = bounded ? std::max(edge.weight, kLeastEdge) : edge.weight;
      const int a = place_[edge.a], b = place_[edge.b];
      if (a >= 0) diagonal[a] += w;
      if (b >= 0) diagonal[b] += w;
      if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), -w);
      if (a >= 0 && b < 0) towards_.push_back({a, edge.b, w});
      if (b >= 0 && a < 0) towards_.push_back({b, edge.a, w});
    }
    for (int i = 0; i < SizeOf(diagonal); ++i) entries.emplace_back(i, i, diagonal[i]);
    lower_.resize(std::ssize(vertices_), std::ssize(vertices_));
    lower_.setFromTriplets(entries.begin(), entries.end());
  }

  /// Adds to the diagonal of one free vertex, so that a part without fixed vertices is not
  /// singular.
  void Ground(int vertex) { lower_.coeffRef(place_[vertex], place_[vertex]) += 1; }
  const std::vector<int>& vertices() const { return vertices_; }
  const Eigen::SparseMatrix<double>& lower() const { return lower_; }

  struct Towards {
    int row, fixed;
    double weight;
  };
  const std::vector<Towards>& towards() const { return towards_; }

 private:
  std::vector<int> place_, vertices_;
  Eigen::SparseMatrix<double> lower_;
  std::vector<Towards> towards_;
};

/// Weights of the free vertices, appended to their rows mark by mark.
void SolveFree(const FreeLaplacian& laplacian, int marks, const std::vector<Row>& fixed_rows,
               double least, std::vector<Row>& rows) {
  BlockCholesky solver;
  solver.Analyze(laplacian.lower());
  solver.Factor(laplacian.lower());
  const Eigen::Index n = std::ssize(laplacian.vertices());
  for (int first = 0; first < marks; first += kColumns) {
    const int count = std::min(kColumns, marks - first);
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(n, count);
    for (const auto& [row, fixed, weight] : laplacian.towards())
      for (const auto& [mark, share] : fixed_rows[fixed])
        if (mark >= first && mark < first + count) x(row, mark - first) += weight * share;
    solver.SolveInPlace(x);
    ParallelFor(
        n,
        [&](std::int64_t i) {
          for (int c = 0; c < count; ++c)
            if (std::abs(x(i, c)) >= least)
              rows[laplacian.vertices()[i]].emplace_back(first + c, x(i, c));
        },
        1024);
  }
}

/// For each vertex the lowest vertex of its connected part.
std::vector<int> PartsOf(Eigen::Index vertices, const FacesX3& faces) {
  UnionFind joined(vertices);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) joined.Join(faces(f, 0), faces(f, k));
  std::vector<int> parts(vertices);
  for (int i = 0; i < static_cast<int>(vertices); ++i) parts[i] = joined.Find(i);
  return parts;
}

/// Gives each part without marks the row of the nearest vertex of the others.
void FollowNearest(const PointsX3& points, const std::vector<int>& parts,
                   const std::vector<char>& has_mark, std::vector<Row>& rows) {
  std::vector<int> marked;
  for (int i = 0; i < SizeOf(parts); ++i)
    if (has_mark[parts[i]]) marked.push_back(i);
  PointsX3 places(std::ssize(marked), 3);
  for (int k = 0; k < SizeOf(marked); ++k) places.row(k) = points.row(marked[k]);
  const KdTree tree(places);
  std::map<int, std::pair<double, int>> nearest;  // of each part
  for (int i = 0; i < SizeOf(parts); ++i) {
    if (has_mark[parts[i]]) continue;
    const int k = tree.Nearest(points.row(i)).index;
    const double distance = (places.row(k) - points.row(i)).norm();
    const auto [at, fresh] = nearest.try_emplace(parts[i], distance, marked[k]);
    if (!fresh && distance < at->second.first) at->second = {distance, marked[k]};
  }
  for (int i = 0; i < SizeOf(parts); ++i)
    if (!has_mark[parts[i]]) rows[i] = rows[nearest.at(parts[i]).second];
}

void RequireMarkedFaces(const std::vector<int>& marked_faces, Eigen::Index faces) {
  if (marked_faces.empty()) throw InputError("transfer: there are no marks");
  for (std::size_t k = 0; k < marked_faces.size(); ++k)
    if (marked_faces[k] < 0 || marked_faces[k] >= faces)
      throw InputError("transfer: mark " + std::to_string(k) + " is on triangle " +
                       std::to_string(marked_faces[k]) + ", but the mesh has " +
                       std::to_string(faces));
}

}  // namespace

void WeightRows::Append(const std::vector<std::pair<int, double>>& row) {
  for (const auto& term : row) {
    mark.push_back(term.first);
    weight.push_back(term.second);
  }
  begin.push_back(static_cast<int>(mark.size()));
}

Eigen::Vector3d HalfCotangents(const PointsX3& p, const FacesX3& faces, Eigen::Index f) {
  const Eigen::RowVector3d p0 = p.row(faces(f, 0)), p1 = p.row(faces(f, 1)),
                           p2 = p.row(faces(f, 2));
  const Eigen::RowVector3d e0 = p2 - p1, e1 = p0 - p2, e2 = p1 - p0;
  const double doubled = e1.cross(e2).norm();
  if (!(doubled > kSliver * std::max({e0.squaredNorm(), e1.squaredNorm(), e2.squaredNorm()})))
    return Eigen::Vector3d::Constant(1e-3);
  return Eigen::Vector3d(-e1.dot(e2), -e2.dot(e0), -e0.dot(e1)) / (2 * doubled);
}

MarkFields::MarkFields(const PointsX3& points, const FacesX3& faces,
                       const std::vector<int>& marked_faces, const MarkFieldOptions& options)
    : marks_(SizeOf(marked_faces)), own_row_(faces.rows(), -1) {
  RequireMarkedFaces(marked_faces, faces.rows());
  const Eigen::Index n = points.rows();
  std::vector<Row> rows(n), own(faces.rows());
  std::vector<std::vector<int>> at_vertex(n);
  for (int k = 0; k < marks_; ++k) {
    own[marked_faces[k]].emplace_back(k, 1.0);
    for (int c = 0; c < 3; ++c) at_vertex[faces(marked_faces[k], c)].push_back(k);
  }
  std::vector<char> fixed(n, 0), has_mark(n, 0);
  const std::vector<int> parts = PartsOf(n, faces);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (at_vertex[i].empty()) continue;
    fixed[i] = has_mark[parts[i]] = 1;
    for (int k : at_vertex[i])
      rows[i].emplace_back(k, 1.0 / static_cast<double>(at_vertex[i].size()));
  }
  FreeLaplacian laplacian(points, faces, fixed, options.bounded);
  for (int i = 0; i < static_cast<int>(n); ++i)
    if (parts[i] == i && !has_mark[i]) {
      laplacian.Ground(i);
      ++unmarked_parts_;
    }
  if (!laplacian.vertices().empty())
    SolveFree(laplacian, marks_, rows, std::min(options.least_weight, 1e-13), rows);
  for (int i : laplacian.vertices())
    for (const auto& term : rows[i]) least_ = std::min(least_, term.second);
  if (unmarked_parts_ > 0) FollowNearest(points, parts, has_mark, rows);
  ParallelFor(
      n, [&](std::int64_t i) { rows[i] = Kept(std::move(rows[i]), options.least_weight); }, 512);
  for (const Row& row : rows) vertices_.Append(row);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    if (own[f].empty()) continue;
    own_row_[f] = own_rows_.rows();
    own_rows_.Append(Kept(own[f], 0));
  }
}

}  // namespace keypose::motion
