#include "register/nricp/correspondence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"

namespace keypose::registration {

namespace {
constexpr std::int64_t kGrain = 256;
// Below this barycentric coordinate a closest point counts as on the opposite edge.
constexpr double kOnEdge = 1e-9;
}  // namespace

struct TargetSurface::Impl {
  Impl(const PointsX3& points, const FacesX3& f)
      : faces(f), normals(VertexNormals(points, f)), scene(points, f) {
    FindOpenEdges();
  }
  /// Finds edges with one face. Edges are grouped by their lower vertex, which is much faster than
  /// a map of edges.
  void FindOpenEdges() {
    struct Side {
      int other, face, corner;  // the corner opposite to it
    };
    std::vector<int> offset(normals.rows() + 1, 0);
    const auto ends = [&](Eigen::Index t, int k) {
      return std::pair(std::minmax(faces(t, (k + 1) % 3), faces(t, (k + 2) % 3)));
    };
    for (Eigen::Index t = 0; t < faces.rows(); ++t)
      for (int k = 0; k < 3; ++k) ++offset[ends(t, k).first + 1];
    std::partial_sum(offset.begin(), offset.end(), offset.begin());
    std::vector<Side> sides(faces.size());
    std::vector<int> next(offset.begin(), offset.end() - 1);
    for (Eigen::Index t = 0; t < faces.rows(); ++t)
      for (int k = 0; k < 3; ++k) {
        const auto [low, high] = ends(t, k);
        sides[next[low]++] = {high, static_cast<int>(t), k};
      }
    open_edge.assign(faces.rows(), {false, false, false});
    open_vertex.assign(normals.rows(), 0);
    for (std::size_t v = 0; v + 1 < offset.size(); ++v) {
      std::sort(sides.begin() + offset[v], sides.begin() + offset[v + 1],
                [](const Side& s, const Side& t) { return s.other < t.other; });
      for (int s = offset[v], run = s; s < offset[v + 1]; s = run) {
        while (run < offset[v + 1] && sides[run].other == sides[s].other) ++run;
        if (run - s != 1) continue;
        open_edge[sides[s].face][sides[s].corner] = true;
        open_vertex[v] = open_vertex[sides[s].other] = 1;
      }
    }
  }
  /// @param near  a point on the surface, up to rounding; nothing farther away is searched
  RayScene::Foot ClosestPoint(const Eigen::Vector3d& p, const Eigen::Vector3d& near) const {
    const RayScene::Foot foot =
        scene.ClosestPoint(p, (1 + 1e-9) * (near - p).norm() + 1e-12 * p.norm());
    return foot.face >= 0 ? foot : scene.ClosestPoint(p);
  }
  bool OnBoundary(const RayScene::Foot& foot) const {
    for (int k = 0; k < 3; ++k) {
      if (foot.barycentric[k] <= kOnEdge && open_edge[foot.face][k]) return true;
      if (foot.barycentric[k] >= 1 - kOnEdge && open_vertex[faces(foot.face, k)]) return true;
    }
    return false;
  }
  Eigen::Vector3d NormalAt(const RayScene::Foot& foot) const {
    Eigen::Vector3d n = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      n += foot.barycentric[k] * normals.row(faces(foot.face, k)).transpose();
    return n;
  }

  FacesX3 faces;
  PointsX3 normals;
  RayScene scene;
  std::vector<std::array<bool, 3>> open_edge;
  std::vector<char> open_vertex;
};

TargetSurface::TargetSurface(const PointsX3& points, const FacesX3& faces) {
  Mesh mesh;
  mesh.points = points;
  mesh.faces = faces;
  RequireUsable(mesh, "register: target");
  impl_ = std::make_unique<Impl>(points, faces);
}

TargetSurface::~TargetSurface() = default;

Correspondences TargetSurface::Find(const PointsX3& moved, const FacesX3& source_faces) const {
  const PointsX3 normals = VertexNormals(moved, source_faces);
  Correspondences found{PointsX3(moved.rows(), 3), Eigen::VectorXd::Zero(moved.rows())};
  ParallelBlocks(moved.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Eigen::Vector3d p = moved.row(i);
      const RayScene::Foot foot = impl_->scene.ClosestPoint(p);
      found.closest.row(i) = foot.face < 0 ? p : foot.point;
      if (foot.face < 0 || !(normals.row(i).dot(impl_->NormalAt(foot)) > 0) ||
          impl_->OnBoundary(foot))
        continue;
      found.weights[i] = 1;
    }
  });
  return found;
}

Feet TargetSurface::FindFeet(const PointsX3& points, const PointsX3& normals, double min_cosine,
                             const PointsX3* near) const {
  const std::size_t count = points.rows();
  Feet feet{PointsX3(points.rows(), 3), PointsX3::Zero(points.rows(), 3),
            std::vector<int>(count, -1), PointsX3::Zero(points.rows(), 3),
            std::vector<char>(count, 0)};
  ParallelBlocks(points.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Eigen::Vector3d p = points.row(i);
      const RayScene::Foot foot =
          near ? impl_->ClosestPoint(p, near->row(i)) : impl_->scene.ClosestPoint(p);
      feet.points.row(i) = foot.face < 0 ? p : foot.point;
      if (foot.face < 0) continue;
      const Eigen::Vector3d n = impl_->NormalAt(foot);
      feet.normals.row(i) = n;
      feet.faces[i] = foot.face;
      feet.barycentric.row(i) = foot.barycentric;
      feet.allowed[i] = normals.row(i).dot(n) >= min_cosine * n.norm() && !impl_->OnBoundary(foot);
    }
  });
  return feet;
}

Eigen::VectorXd TargetSurface::Distances(const PointsX3& points) const {
  Eigen::VectorXd d(points.rows());
  ParallelBlocks(points.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      d[i] = std::sqrt(impl_->scene.ClosestPoint(points.row(i)).squared_distance);
  });
  return d;
}

}  // namespace keypose::registration
