#include "texture/bake/face_split.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3d;

constexpr double kMostPixels = 400;
constexpr int kMostFaces = 400000;

/// Appends rows for the middles of the edges of `faces` to `rows`; the number of faces grows
/// fourfold.
template <class Rows>
void SplitAtMiddles(Rows& rows, FacesX3& faces) {
  const auto edges = UndirectedEdges(faces);
  const auto first = rows.rows();
  rows.conservativeResize(first + std::ssize(edges), rows.cols());
  for (std::size_t e = 0; e < edges.size(); ++e)
    rows.row(first + static_cast<Eigen::Index>(e)) =
        0.5 * (rows.row(edges[e].first) + rows.row(edges[e].second));
  const auto middle = [&](int a, int b) {
    if (a == b) return a;  // texture coordinates may coincide
    const auto at =
        std::lower_bound(edges.begin(), edges.end(), std::pair(std::min(a, b), std::max(a, b)));
    return static_cast<int>(first + (at - edges.begin()));
  };
  FacesX3 split(4 * faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const int a = faces(f, 0), b = faces(f, 1), c = faces(f, 2);
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    split.row(4 * f) << a, ab, ca;
    split.row(4 * f + 1) << ab, b, bc;
    split.row(4 * f + 2) << ca, bc, c;
    split.row(4 * f + 3) << ab, bc, ca;
  }
  faces = std::move(split);
}

double MedianPixels(const Mesh& mesh, const std::vector<View>& views) {
  return UpperMedian(Eigen::VectorXd(
      FaceAreas(mesh.points, mesh.faces).cwiseProduct(PixelsPerUnit(mesh, views).cwiseAbs2())));
}

}  // namespace

Eigen::VectorXd PixelsPerUnit(const Mesh& mesh, const std::vector<View>& views) {
  const PointsX3 normals = FaceNormals(mesh.points, mesh.faces);
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(mesh.face_count());
  std::vector<Vector3d> centers;
  for (const View& view : views) centers.push_back(view.Center());
  ParallelFor(
      mesh.face_count(),
      [&](std::int64_t f) {
        const Vector3d x = (mesh.points.row(mesh.faces(f, 0)) + mesh.points.row(mesh.faces(f, 1)) +
                            mesh.points.row(mesh.faces(f, 2))) /
                           3;
        for (std::size_t v = 0; v < views.size(); ++v) {
          const double depth = (views[v].camera_from_world * x).z();
          if (depth > 0 && normals.row(f).dot((centers[v] - x).normalized()) > 0.5)
            scale[f] = std::max(scale[f], views[v].camera.fx / depth);
        }
      },
      256);
  return scale;
}

Mesh SplitLargeFaces(const Mesh& mesh, const std::vector<View>& views) {
  Mesh split;
  split.points = mesh.points;
  split.faces = mesh.faces;
  split.uvs = mesh.uvs;
  split.uv_faces = mesh.uv_faces;
  for (double pixels = MedianPixels(mesh, views);
       pixels > kMostPixels && 4 * split.face_count() <= kMostFaces; pixels /= 4) {
    SplitAtMiddles(split.points, split.faces);
    SplitAtMiddles(split.uvs, split.uv_faces);
  }
  return split;
}

}  // namespace keypose::texture
