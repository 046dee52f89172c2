#include "register/intrinsic/dense_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/values/tuned.h"

namespace keypose::registration {

namespace {

// Chosen on the seven registration pairs (docs/results/landmarks.md); sensitivity:
// docs/results/sensitivity.md.
struct DenseMapTuning {
  // Errors at which the confidence has fallen to 1/e. Lengths are over the square root of the area.
  KEYPOSE_TUNED(double, kReturnError, 0.06);    // distance of a point mapped there and back
  KEYPOSE_TUNED(double, kDistanceError, 0.12);  // mean change of the distances to the samples
  KEYPOSE_TUNED(double, kStretchError, 0.7);    // mean change of edges over the sum of lengths
};

std::vector<std::vector<int>> FacesAround(const Mesh& mesh) {
  std::vector<std::vector<int>> around(static_cast<std::size_t>(mesh.vertex_count()));
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) around[mesh.faces(f, k)].push_back(static_cast<int>(f));
  return around;
}

/// Barycentric coordinates of the point of triangle abc closest to p, in any dimension. The
/// arguments are inner products of u = b-a, v = c-a and w = p-a.
Eigen::Vector3d ClosestInTriangle(double uu, double uv, double vv, double uw, double vw) {
  const double det = uu * vv - uv * uv;
  if (det > 1e-14 * uu * vv) {
    const double s = (vv * uw - uv * vw) / det, t = (uu * vw - uv * uw) / det;
    if (s >= 0 && t >= 0 && s + t <= 1) return {1 - s - t, s, t};
  }
  const auto clamp = [](double x) { return std::clamp(x, 0.0, 1.0); };
  const double s = uu > 0 ? clamp(uw / uu) : 0, t = vv > 0 ? clamp(vw / vv) : 0;
  const double ee = uu + vv - 2 * uv;                             // |c - b|^2
  const double r = ee > 0 ? clamp((vw - uw + uu - uv) / ee) : 0;  // along bc
  const auto cost = [&](double x, double y) {
    return x * x * uu + 2 * x * y * uv + y * y * vv - 2 * (x * uw + y * vw);
  };
  const double on_ab = cost(s, 0), on_ac = cost(0, t), on_bc = cost(1 - r, r);
  if (on_ab <= on_ac && on_ab <= on_bc) return {1 - s, s, 0};
  if (on_ac <= on_bc) return {1 - t, 0, t};
  return {0, 1 - r, r};
}

/// Which of the given faces is closest to a row, in the space of the rows, and its closest point.
template <class Rows, class Row>
std::pair<int, Eigen::Vector3d> ClosestFace(const Rows& rows, const FacesX3& faces,
                                            const std::vector<int>& some, const Row& p) {
  std::pair<int, Eigen::Vector3d> best{-1, Eigen::Vector3d::Zero()};
  double least = std::numeric_limits<double>::infinity();
  for (const int f : some) {
    const auto a = rows.row(faces(f, 0));
    const auto u = (rows.row(faces(f, 1)) - a).eval();
    const auto v = (rows.row(faces(f, 2)) - a).eval();
    const auto w = (p - a).eval();
    const double uw = u.dot(w), vw = v.dot(w), uu = u.squaredNorm(), vv = v.squaredNorm(),
                 uv = u.dot(v);
    const Eigen::Vector3d b = ClosestInTriangle(uu, uv, vv, uw, vw);
    const double d = w.squaredNorm() - 2 * (b[1] * uw + b[2] * vw) + b[1] * b[1] * uu +
                     2 * b[1] * b[2] * uv + b[2] * b[2] * vv;
    if (d < least) {
      least = d;
      best = {f, b};
    }
  }
  return best;
}

void AddUnique(std::vector<int>& list, const std::vector<int>& more) {
  for (const int x : more)
    if (std::find(list.begin(), list.end(), x) == list.end()) list.push_back(x);
}

Eigen::RowVector3d PositionOf(const Mesh& proxy, const OnProxy& at, std::size_t v) {
  Eigen::RowVector3d p = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k)
    p += at.barycentric(static_cast<Eigen::Index>(v), k) *
         proxy.points.row(proxy.faces(at.face[v], k));
  return p;
}

}  // namespace

OnProxy FootOnProxy(const Mesh& mesh, const IntrinsicShape& shape) {
  const std::vector<std::vector<int>> around = FacesAround(shape.proxy);
  const double scale = shape.scale;
  OnProxy feet{std::vector<int>(static_cast<std::size_t>(mesh.vertex_count()), -1),
               PointsX3::Zero(mesh.vertex_count(), 3)};
  ParallelFor(
      mesh.vertex_count(),
      [&](std::int64_t v) {
        const int p = shape.proxy_of[v];
        if (p < 0) return;
        const Eigen::RowVector3d at = mesh.points.row(v) / scale;
        const auto [face, barycentric] =
            ClosestFace(shape.proxy.points, shape.proxy.faces, around[p], at);
        feet.face[v] = face;
        feet.barycentric.row(v) = barycentric.transpose();
      },
      256);
  return feet;
}

OnProxy PreciseMap(const IntrinsicShape& source, const OnProxy& source_feet,
                   const IntrinsicShape& target, const PointMaps& maps,
                   const JointEmbedding& joint) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const RowMajor a = joint.SourceRows(source.all.functions),
                 b = joint.TargetRows(target.all.functions);
  const std::vector<std::vector<int>> around = FacesAround(target.proxy);
  const auto count = std::ssize(source_feet.face);
  OnProxy mapped{std::vector<int>(source_feet.face.size(), -1), PointsX3::Zero(count, 3)};
  ParallelFor(
      count,
      [&](std::int64_t v) {
        const int face = source_feet.face[v];
        if (face < 0) return;
        Eigen::RowVectorXf row = Eigen::RowVectorXf::Zero(a.cols());
        std::vector<int> faces;
        for (int k = 0; k < 3; ++k) {
          const int corner = source.proxy.faces(face, k);
          row += static_cast<float>(source_feet.barycentric(v, k)) * a.row(corner);
          AddUnique(faces, around[maps.forward[corner]]);
        }
        const auto [best, barycentric] = ClosestFace(b, target.proxy.faces, faces, row);
        mapped.face[v] = best;
        mapped.barycentric.row(v) = barycentric.transpose();
      },
      64);
  return mapped;
}

std::vector<int> NearestVertices(const Mesh& target_mesh, const IntrinsicShape& target,
                                 const OnProxy& mapped) {
  std::vector<std::vector<int>> members(static_cast<std::size_t>(target.proxy.vertex_count()));
  for (std::size_t v = 0; v < target.proxy_of.size(); ++v)
    if (target.proxy_of[v] >= 0) members[target.proxy_of[v]].push_back(static_cast<int>(v));
  std::vector<int> nearest(mapped.face.size(), -1);
  ParallelFor(
      std::ssize(nearest),
      [&](std::int64_t i) {
        const auto v = static_cast<std::size_t>(i);
        if (mapped.face[v] < 0) return;
        const Eigen::RowVector3d at = PositionOf(target.proxy, mapped, v) * target.scale;
        double least = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k)
          for (const int w : members[target.proxy.faces(mapped.face[v], k)]) {
            const double d = (target_mesh.points.row(w) - at).squaredNorm();
            if (d < least) {
              least = d;
              nearest[v] = w;
            }
          }
      },
      256);
  return nearest;
}

Eigen::VectorXd MapConfidence(const IntrinsicShape& source, const IntrinsicShape& target,
                              const PointMaps& maps) {
  const auto image = [&](int v) { return maps.forward[v]; };
  const auto fall = [](double x, double scale) { return std::exp(-(x / scale) * (x / scale)); };
  const Eigen::VectorXd weights =
      source.sampled.weights.cast<double>() / source.sampled.weights.cast<double>().sum();
  Eigen::VectorXd confidence(source.proxy.vertex_count());
  for (int v = 0; v < source.proxy.vertex_count(); ++v) {
    const int there = image(v), back = maps.backward[there];
    const double away = (source.proxy.points.row(back) - source.proxy.points.row(v)).norm();
    double changed = 0;
    for (std::size_t s = 0; s < source.samples.size(); ++s)
      changed +=
          weights[static_cast<Eigen::Index>(s)] *
          std::abs(source.sample_distances(static_cast<Eigen::Index>(s), v) -
                   target.sample_distances(target.sample_of[image(source.samples[s])], there));
    double stretch = 0;
    const auto& ring = source.graph->neighbors()[v];
    for (const int w : ring) {
      const double before = (source.proxy.points.row(w) - source.proxy.points.row(v)).norm();
      const double after =
          (target.proxy.points.row(image(w)) - target.proxy.points.row(there)).norm();
      stretch +=
          std::abs(after - before) / (after + before + 1e-12) / static_cast<double>(ring.size());
    }
    confidence[v] = fall(away, DenseMapTuning::kReturnError) *
                    fall(changed, DenseMapTuning::kDistanceError) *
                    fall(stretch, DenseMapTuning::kStretchError);
  }
  return confidence;
}

double OrientationShare(const IntrinsicShape& source, const IntrinsicShape& target,
                        const std::vector<int>& map) {
  double kept = 0, all = 1e-300;
  for (Eigen::Index f = 0; f < source.proxy.faces.rows(); ++f) {
    Eigen::Vector3i v;
    for (int k = 0; k < 3; ++k) v[k] = map[source.proxy.faces(f, k)];
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    const Eigen::Vector3d a = target.proxy.points.row(v[0]), b = target.proxy.points.row(v[1]),
                          c = target.proxy.points.row(v[2]);
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const Eigen::Vector3d expected =
        (target.proxy.normals.row(v[0]) + target.proxy.normals.row(v[1]) +
         target.proxy.normals.row(v[2]))
            .transpose();
    all += normal.norm();
    if (normal.dot(expected) > 0) kept += normal.norm();
  }
  return kept / all;
}

}  // namespace keypose::registration
