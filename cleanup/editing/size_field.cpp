#include "cleanup/editing/size_field.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"

namespace keypose::cleanup {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr double kFieldCountTolerance = 1e-3;

using Edges = std::vector<std::pair<int, int>>;

// The neighbours of all vertices in one array.
struct Adjacency {
  std::vector<int> begin, other;
  Adjacency(int vertices, const Edges& edges) : begin(vertices + 1, 0), other(2 * edges.size()) {
    for (const auto& [a, b] : edges) {
      ++begin[a + 1];
      ++begin[b + 1];
    }
    for (int v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
    std::vector<int> at(begin.begin(), begin.end() - 1);
    for (const auto& [a, b] : edges) {
      other[at[a]++] = b;
      other[at[b]++] = a;
    }
  }
};

PointsX3 SmoothNormals(const Mesh& mesh, const Edges& edges) {
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  PointsX3 sum = normals;
  for (const auto& [a, b] : edges) {
    sum.row(a) += 0.5 * normals.row(b);
    sum.row(b) += 0.5 * normals.row(a);
  }
  return sum.rowwise().normalized();
}

// The largest singular value of the linear map from a step on the face to the change of the normal.
double FaceCurvature(const Mesh& mesh, const PointsX3& normals, int f) {
  const Eigen::Vector3d a = mesh.points.row(mesh.faces(f, 0)),
                        b = mesh.points.row(mesh.faces(f, 1)),
                        c = mesh.points.row(mesh.faces(f, 2));
  const Eigen::Vector3d cross = (b - a).cross(c - a);
  const double twice_area = cross.norm();
  if (!(twice_area > 0)) return 0;
  const Eigen::Vector3d n = cross / twice_area;
  const Eigen::Vector3d gradient[3] = {n.cross(c - b) / twice_area, n.cross(a - c) / twice_area,
                                       n.cross(b - a) / twice_area};
  Eigen::Matrix3d change = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k)
    change += normals.row(mesh.faces(f, k)).transpose() * gradient[k].transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(change.transpose() * change, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

// Limits sizes so that none exceeds a neighbouring one by more than `growth` times the distance
// (Dijkstra from the smallest size).
void LimitGrowth(const Mesh& mesh, const Adjacency& near, double growth, Eigen::VectorXd& sizes) {
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (int v = 0; v < mesh.vertex_count(); ++v) queue.emplace(sizes[v], v);
  while (!queue.empty()) {
    const auto [size, v] = queue.top();
    queue.pop();
    if (size > sizes[v]) continue;
    for (int i = near.begin[v]; i < near.begin[v + 1]; ++i) {
      const int w = near.other[i];
      const double most = size + growth * (mesh.points.row(v) - mesh.points.row(w)).norm();
      if (sizes[w] <= most) continue;
      sizes[w] = most;
      queue.emplace(most, w);
    }
  }
}

double FacesNeeded(const Mesh& mesh, const Eigen::VectorXd& areas, const Eigen::VectorXd& sizes) {
  double count = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const double size =
        (sizes[mesh.faces(f, 0)] + sizes[mesh.faces(f, 1)] + sizes[mesh.faces(f, 2)]) / 3;
    count += areas[f] / (std::sqrt(3.0) / 4 * size * size);
  }
  return count;
}

}  // namespace

Eigen::VectorXd MaxCurvature(const Mesh& surface) {
  const PointsX3 normals = SmoothNormals(surface, UndirectedEdges(surface.faces));
  const Eigen::VectorXd areas = FaceAreas(surface.points, surface.faces);
  Eigen::VectorXd squared = Eigen::VectorXd::Zero(surface.vertex_count()), weight = squared;
  for (int f = 0; f < surface.face_count(); ++f) {
    const double curvature = FaceCurvature(surface, normals, f);
    for (int k = 0; k < 3; ++k) {
      squared[surface.faces(f, k)] += areas[f] * curvature * curvature;
      weight[surface.faces(f, k)] += areas[f];
    }
  }
  return (squared.array() / weight.array().max(1e-300)).sqrt();
}

Eigen::VectorXd Thickness(const Mesh& surface) {
  const RayScene scene(surface.points, surface.faces);
  const PointsX3 normals = VertexNormals(surface.points, surface.faces),
                 face_normals = FaceNormals(surface.points, surface.faces);
  const double skin = 1e-5 * BoundingDiagonal(surface.points);
  Eigen::VectorXd thickness(surface.vertex_count());
  ParallelFor(
      surface.vertex_count(),
      [&](std::int64_t v) {
        const Eigen::Vector3d normal = normals.row(v).transpose();
        const RayScene::Hit hit =
            scene.Cast(surface.points.row(v).transpose() - skin * normal, -normal);
        // A face with the same orientation is another fold of a broken surface, not the other side.
        const bool other_side = hit.face >= 0 && face_normals.row(hit.face).dot(normals.row(v)) < 0;
        thickness[v] = other_side ? hit.distance + skin : kUnbounded;
      },
      256);
  return thickness;
}

Eigen::VectorXd EdgeSizes(const Mesh& surface, const SizeRules& rules) {
  using Tuning = EdgeSizeTuning;
  const Eigen::VectorXd areas = FaceAreas(surface.points, surface.faces);
  const double even = std::sqrt(4 / std::sqrt(3.0) * areas.sum() / rules.faces);
  const Eigen::VectorXd curvature = MaxCurvature(surface), thickness = Thickness(surface);
  const Adjacency near(surface.vertex_count(), UndirectedEdges(surface.faces));
  Eigen::VectorXd limb(surface.vertex_count());
  for (int v = 0; v < surface.vertex_count(); ++v) {
    const bool round = curvature[v] * thickness[v] / 2 >= Tuning::kRound;
    limb[v] = round ? std::max(Tuning::kLimbShare * thickness[v], Tuning::kLimbSmallest * even)
                    : kUnbounded;
  }
  const auto sizes_for = [&](double scale) {
    Eigen::VectorXd sizes(surface.vertex_count());
    for (int v = 0; v < surface.vertex_count(); ++v) {
      // The distance of a chord is proportional to curvature * size^2, and the number of faces to 1
      // / size^2. The exponents 1/3 and 1/2 follow from this.
      const double bent = std::pow(std::max(curvature[v] * even, 1e-9), -rules.exponent) * scale;
      sizes[v] = std::min(
          even * (rules.follow_curvature ? std::clamp(bent, Tuning::kSmallest, Tuning::kLargest)
                                         : scale),
          limb[v]);
    }
    LimitGrowth(surface, near, rules.growth, sizes);
    return sizes;
  };
  // The number of faces is about proportional to 1 / scale^2. Bracketing handles the cases where
  // limits prevent that.
  double low = 1e-3, high = 1e3, scale = 1;
  for (int round = 0; round < 24; ++round) {
    Eigen::VectorXd sizes = sizes_for(scale);
    const double over = FacesNeeded(surface, areas, sizes) / rules.faces;
    if (std::abs(over - 1) < kFieldCountTolerance) return sizes;
    (over > 1 ? low : high) = scale;
    const double next = scale * std::sqrt(over);
    scale = next > low && next < high ? next : std::sqrt(low * high);
  }
  return sizes_for(high);
}

void Refine(const Mesh& surface, const PointsX3& places, double reach, Eigen::VectorXd& sizes) {
  if (places.rows() == 0) return;
  const KdTree tree(places);
  for (int v = 0; v < surface.vertex_count(); ++v) {
    if (std::sqrt(tree.Nearest(surface.points.row(v).transpose()).squared_distance) <
        reach * sizes[v])
      sizes[v] /= 2;
  }
}

}  // namespace keypose::cleanup
