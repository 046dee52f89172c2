#include "cleanup/support/unseen.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"

namespace keypose::cleanup {
namespace {

using Eigen::Vector3d;

constexpr double kLeastSine = 0.17364817766693033;  // of 10 degrees
constexpr double kSoleHeight = 0.05;                // of the height
constexpr double kSoleDown = 0.7071067811865476;    // cosine of 45 degrees
constexpr double kNear = 1e-4;  // of the line of sight: beyond the rounding of single precision

bool Shows(const View& view, const Vector3d& point) {
  if ((view.camera_from_world * point).z() <= 0) return false;
  const Eigen::Vector2d pixel = view.Project(point);
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= view.camera.width &&
         pixel.y() <= view.camera.height;
}

bool Sees(const View& view, const Vector3d& eye, const RayScene& scene, const Vector3d& point,
          const Vector3d& normal) {
  const Vector3d to_eye = eye - point;
  if (normal.dot(to_eye) < kLeastSine * to_eye.norm() || !Shows(view, point)) return false;
  return !scene.Occluded(point, to_eye, kNear, 1);
}

}  // namespace

UnseenSurface MeasureUnseen(const Mesh& mesh, const std::vector<View>& views) {
  const RayScene scene(mesh.points, mesh.faces);
  const PointsX3 normals = FaceNormals(mesh.points, mesh.faces);
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  std::vector<Vector3d> eyes;
  for (const View& view : views) eyes.push_back(view.Center());
  std::vector<char> seen(static_cast<std::size_t>(mesh.face_count()), 0);
  PointsX3 middles(mesh.face_count(), 3);
  ParallelFor(mesh.face_count(), [&](std::int64_t f) {
    const Vector3d middle = (mesh.points.row(mesh.faces(f, 0)) + mesh.points.row(mesh.faces(f, 1)) +
                             mesh.points.row(mesh.faces(f, 2)))
                                .transpose() /
                            3;
    middles.row(f) = middle.transpose();
    for (std::size_t v = 0; v < views.size() && !seen[f]; ++v)
      seen[f] = Sees(views[v], eyes[v], scene, middle, normals.row(f).transpose());
  });
  const double lowest = mesh.points.col(2).minCoeff(),
               height = mesh.points.col(2).maxCoeff() - lowest;
  UnseenSurface unseen;
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (seen[f]) continue;
    const bool sole = normals(f, 2) < -kSoleDown && middles(f, 2) < lowest + kSoleHeight * height;
    (sole ? unseen.sole_share : unseen.share) += areas[f] / areas.sum();
  }
  return unseen;
}

}  // namespace keypose::cleanup
