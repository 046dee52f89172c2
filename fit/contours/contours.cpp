#include "fit/contours/contours.h"

namespace keypose::fit {
namespace {

// How far beyond a contour the picture must show nothing for it to be the silhouette [px].
constexpr double kBeyond = 1.5;

}  // namespace

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
    ContourPoint point{pair.a,        pair.b,
                       (pa + pb) / 2, Eigen::Vector2d(along.y(), -along.x()) * (sign / length),
                       length,        (xa.z() + xb.z()) / 2};
    const Eigen::Vector2d beyond = point.pixel + kBeyond * point.normal;
    if (scene.Cast(eye, world_from_camera * camera.Ray(beyond.x(), beyond.y())).face >= 0) continue;
    contour.push_back(point);
  }
  return contour;
}

}  // namespace keypose::fit
