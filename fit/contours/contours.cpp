#include "fit/contours/contours.h"

#include <algorithm>
#include <array>

#include "core/size_of.h"

namespace keypose::fit {
namespace {

// How far beyond a contour the picture must show nothing for it to be the silhouette [px].
constexpr double kBeyond = 1.5;

struct HalfEdge {
  int low, high, face;
  bool forward;  // from low to high
  bool operator<(const HalfEdge& other) const {
    return std::array{low, high, face} < std::array{other.low, other.high, other.face};
  }
};

std::vector<HalfEdge> SortedHalfEdges(const FacesX3& faces) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * faces.rows());
  for (int f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

FacePairs FindFacePairs(const FacesX3& faces) {
  const std::vector<HalfEdge> edges = SortedHalfEdges(faces);
  FacePairs result;
  for (int i = 0; i < SizeOf(edges);) {
    int end = i + 1;
    while (end < SizeOf(edges) && edges[end].low == edges[i].low && edges[end].high == edges[i].high)
      ++end;
    if (end == i + 2 && edges[i].forward != edges[i + 1].forward) {
      const HalfEdge &left = edges[i].forward ? edges[i] : edges[i + 1],
                     &right = edges[i].forward ? edges[i + 1] : edges[i];
      result.pairs.push_back({left.low, left.high, left.face, right.face});
    }
    i = end;
  }
  return result;
}

std::vector<ContourPoint> FindSilhouette(const PointsX3& points, const FacesX3& faces,
                                         const FacePairs& pairs, const RayScene& scene,
                                         const Pinhole& camera, const Rigid3& camera_from_world) {
  const Eigen::Vector3d eye = camera_from_world.Inverse().translation;
  const Eigen::Quaterniond world_from_camera = camera_from_world.rotation.conjugate();
  std::vector<char> towards(faces.rows());
  for (int f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d p = points.row(faces(f, 0)), q = points.row(faces(f, 1)),
                          r = points.row(faces(f, 2));
    towards[f] = (q - p).cross(r - p).dot(eye - p) > 0;
  }
  std::vector<ContourPoint> contour;
  for (const FacePairs::Pair& pair : pairs.pairs) {
    if (towards[pair.left] == towards[pair.right]) continue;
    const Eigen::Vector3d xa = camera_from_world * points.row(pair.a).transpose(),
                          xb = camera_from_world * points.row(pair.b).transpose();
    if (xa.z() <= 0 || xb.z() <= 0) continue;
    const Eigen::Vector2d pa = camera.Project(xa), pb = camera.Project(xb), along = pb - pa;
    const double length = along.norm();
    if (length < 1e-9) continue;
    // A face towards the camera lies to the left of its edges as one looks at the picture. There y
    // points down, so left of (x, y) is (y, -x), and the outside is on the other side.
    const double sign = towards[pair.left] ? -1 : 1;
    ContourPoint point{pair.a, pair.b, (pa + pb) / 2,
                       Eigen::Vector2d(along.y(), -along.x()) * (sign / length), length,
                       (xa.z() + xb.z()) / 2};
    const Eigen::Vector2d beyond = point.pixel + kBeyond * point.normal;
    if (scene.Cast(eye, world_from_camera * camera.Ray(beyond.x(), beyond.y())).face >= 0) continue;
    contour.push_back(point);
  }
  return contour;
}

}  // namespace keypose::fit
