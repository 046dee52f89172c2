#include "interpolate/arap.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include "core/camera.h"
#include "core/cholesky.h"
#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "interpolate/face_maps.h"
#include "interpolate/turns.h"

namespace keypose::interpolation {

namespace {

using EdgeWeights = std::array<double, 3>;  // of the edges opposite corners 0, 1, 2

/// Half cotangents of a triangle's corners.
EdgeWeights HalfCotangents(const PointsX3& p, const FacesX3& faces, Eigen::Index f) {
  EdgeWeights w;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d a = p.row(faces(f, (k + 1) % 3)) - p.row(faces(f, k)), b = p.row(faces(f, (k + 2) % 3)) - p.row(faces(f, k));
    w[k] = 0.5 * a.dot(b) / a.cross(b).norm();
  }
  return w;
}

std::vector<int> ComponentsOf(Eigen::Index vertex_count, const FacesX3& faces) {
  std::vector<int> parent(vertex_count);
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) {
      const int a = find(faces(f, 0)), b = find(faces(f, k));
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<int> component(vertex_count);
  for (int i = 0; i < static_cast<int>(vertex_count); ++i) component[i] = find(i);
  return component;
}

/// Path of each part's centroid: the body's centroid goes straight, the parts' offsets from it turn with the whole body.
class CentroidPaths {
 public:
  CentroidPaths(const PointsX3& v, const PointsX3& u, const FacesX3& faces) : component_(ComponentsOf(v.rows(), faces)) {
    const Eigen::Index n = v.rows();
    count_.setZero(n);
    start_ = end_ = PointsX3::Zero(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
      count_[component_[i]] += 1;
      start_.row(component_[i]) += v.row(i);
      end_.row(component_[i]) += u.row(i);
    }
    for (Eigen::Index c = 0; c < n; ++c)
      if (count_[c] > 0) start_.row(c) /= count_[c], end_.row(c) /= count_[c];
    body_start_ = v.colwise().mean();
    body_end_ = u.colwise().mean();
    if (n >= 3 && (v.rowwise() - v.colwise().mean()).norm() > 0) body_rotation_ = FitSimilarity(v, u, {}, false).rotation;
    body_turn_ = LogOf(body_rotation_);
  }

  /// One vertex of each part: its lowest.
  bool IsGround(Eigen::Index i) const { return component_[i] == i; }

  /// Moves each part so that its centroid lies where it belongs at time t.
  void Apply(double t, PointsX3& points) const {
    PointsX3 mean = PointsX3::Zero(points.rows(), 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) mean.row(component_[i]) += points.row(i);
    const Eigen::Matrix3d turn = ExpOf(t * body_turn_);
    for (Eigen::Index c = 0; c < points.rows(); ++c) {
      if (count_[c] == 0) continue;
      const Eigen::Vector3d d0 = start_.row(c).transpose() - body_start_, d1 = end_.row(c).transpose() - body_end_;
      const Eigen::Vector3d goal = (1 - t) * body_start_ + t * body_end_ + turn * ((1 - t) * d0 + t * (body_rotation_.transpose() * d1));
      mean.row(c) = goal.transpose() - mean.row(c) / count_[c];
    }
    for (Eigen::Index i = 0; i < points.rows(); ++i) points.row(i) += mean.row(component_[i]);
  }

 private:
  std::vector<int> component_;
  Eigen::VectorXd count_;
  PointsX3 start_, end_;
  Eigen::Vector3d body_start_, body_end_;
  Eigen::Matrix3d body_rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d body_turn_;
};

}  // namespace

struct ArapInterpolator::Impl {
  Impl(const PointsX3& v_, const PointsX3& u_, const FacesX3& f, const ArapOptions& o)
      : v(v_), u(u_), faces(f), options(o), maps(FaceMapsOf(v_, u_, f)), paths(v_, u_, f) {
    if (options.follow_turns) MakeTurnsConsistent(faces, maps);
    weights.resize(faces.rows());
    for (Eigen::Index t = 0; t < faces.rows(); ++t) weights[t] = WeightsOf(t);
    BuildIncidence();
    Factor();
  }

  EdgeWeights WeightsOf(Eigen::Index f) const {
    // A face without area has no cotangents: an equilateral triangle's, made small, keep its corners joined.
    if (maps[f].degenerate) return {1e-3, 1e-3, 1e-3};
    EdgeWeights w = HalfCotangents(v, faces, f);
    if (!options.symmetric) return w;
    const EdgeWeights w_u = HalfCotangents(u, faces, f);
    for (int k = 0; k < 3; ++k) w[k] += w_u[k];
    return w;
  }

  void BuildIncidence() {
    first_corner.assign(v.rows() + 1, 0);
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) ++first_corner[faces(f, k) + 1];
    std::partial_sum(first_corner.begin(), first_corner.end(), first_corner.begin());
    corners.resize(3 * faces.rows());
    std::vector<int> at(first_corner.begin(), first_corner.end() - 1);
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) corners[at[faces(f, k)]++] = static_cast<int>(3 * f + k);
  }

  void Factor() {
    std::vector<Eigen::Triplet<double>> triplets;
    triplets.reserve(9 * faces.rows() + v.rows());
    double total = 0;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        const int i = faces(f, (k + 1) % 3), j = faces(f, (k + 2) % 3);
        if (i == j) continue;
        triplets.emplace_back(std::max(i, j), std::min(i, j), -weights[f][k]);
        triplets.emplace_back(i, i, weights[f][k]);
        triplets.emplace_back(j, j, weights[f][k]);
        total += std::abs(weights[f][k]);
      }
    const double ground = std::max(total / static_cast<double>(std::max<Eigen::Index>(1, v.rows())), 1e-12);
    for (Eigen::Index i = 0; i < v.rows(); ++i)
      if (paths.IsGround(i)) triplets.emplace_back(static_cast<int>(i), static_cast<int>(i), ground);
    Eigen::SparseMatrix<double> h(v.rows(), v.rows());
    h.setFromTriplets(triplets.begin(), triplets.end());
    solver.Analyze(h);
    solver.Factor(h);
  }

  /// Per face: the wanted edges at time t, times their weights, summed at each corner.
  void FaceTerms(double t, std::vector<std::array<Eigen::Vector3d, 3>>& terms) const {
    ParallelFor(
        faces.rows(),
        [&](std::int64_t f) {
          std::array<Eigen::Vector3d, 3> edge;  // k: from corner k+1 to corner k+2
          const FaceMap& map = maps[f];
          const Eigen::Matrix2d stretch =
              options.log_stretch ? PowerOf(map.stretch, t) : ((1 - t) * Eigen::Matrix2d::Identity() + t * map.stretch).eval();
          const Eigen::Matrix3d turn = ExpOf(t * map.turn) * ExpOf(t * map.remainder);
          for (int k = 0; k < 3; ++k) {
            const int i = faces(f, (k + 1) % 3), j = faces(f, (k + 2) % 3);
            const Eigen::Vector3d e = (v.row(j) - v.row(i)).transpose();
            if (map.degenerate)
              edge[k] = (1 - t) * e + t * (u.row(j) - u.row(i)).transpose();
            else
              edge[k] = turn * (map.frame * (stretch * (map.frame.transpose() * e)));
          }
          for (int k = 0; k < 3; ++k)  // corner k ends edge k+1 and starts edge k+2
            terms[f][k] = weights[f][(k + 1) % 3] * edge[(k + 1) % 3] - weights[f][(k + 2) % 3] * edge[(k + 2) % 3];
        },
        512);
  }

  PointsX3 v, u;
  FacesX3 faces;
  ArapOptions options;
  std::vector<FaceMap> maps;
  CentroidPaths paths;
  std::vector<EdgeWeights> weights;
  std::vector<int> first_corner, corners;
  SparseCholesky solver;
};

ArapInterpolator::ArapInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces, const ArapOptions& options) {
  if (v.rows() != u.rows())
    throw InputError("interpolate: the keys have " + std::to_string(v.rows()) + " and " + std::to_string(u.rows()) +
                     " vertices; register all poses from one template first");
  Mesh mesh;
  mesh.faces = faces;
  mesh.points = v;
  RequireUsable(mesh, "interpolate: first key");
  mesh.points = u;
  RequireUsable(mesh, "interpolate: second key");
  impl_ = std::make_unique<Impl>(v, u, faces, options);
}

ArapInterpolator::~ArapInterpolator() = default;
ArapInterpolator::ArapInterpolator(ArapInterpolator&&) noexcept = default;

PointsX3 ArapInterpolator::At(double t) const { return At(std::vector<double>{t}).front(); }

std::vector<PointsX3> ArapInterpolator::At(const std::vector<double>& times) const {
  const Impl& s = *impl_;
  const Eigen::Index n = s.v.rows(), count = static_cast<Eigen::Index>(times.size());
  Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(n, 3 * count);
  std::vector<std::array<Eigen::Vector3d, 3>> terms(s.faces.rows());
  for (Eigen::Index c = 0; c < count; ++c) {
    s.FaceTerms(times[c], terms);
    // Gathered by vertex in a fixed order: no two threads add to one sum.
    ParallelFor(
        n,
        [&](std::int64_t i) {
          for (int at = s.first_corner[i]; at < s.first_corner[i + 1]; ++at)
            rhs.block<1, 3>(i, 3 * c) += terms[s.corners[at] / 3][s.corners[at] % 3].transpose();
        },
        1024);
  }
  const Eigen::MatrixXd x = s.solver.Solve(rhs);
  std::vector<PointsX3> frames(count);
  for (Eigen::Index c = 0; c < count; ++c) {
    frames[c] = x.middleCols<3>(3 * c);
    s.paths.Apply(times[c], frames[c]);
  }
  return frames;
}

int ArapInterpolator::degenerate_faces() const {
  return static_cast<int>(std::count_if(impl_->maps.begin(), impl_->maps.end(), [](const FaceMap& m) { return m.degenerate; }));
}

double ArapInterpolator::largest_turn() const {
  double largest = 0;
  for (const FaceMap& m : impl_->maps) largest = std::max(largest, m.turn.norm());
  return largest;
}

PointsX3 InterpolateLinearly(const PointsX3& v, const PointsX3& u, double t) { return (1 - t) * v + t * u; }

}  // namespace keypose::interpolation
