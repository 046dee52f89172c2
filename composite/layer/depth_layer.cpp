#include "composite/layer/depth_layer.h"

#include <algorithm>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"

namespace keypose::composite {

using Eigen::Vector3d;

ImageF DepthLayer(const PointsX3& points, const FacesX3& faces, const View& view,
                  const PixelRays& rays, int along, const Ground& table, const RayScene* props) {
  ImageF depth(view.camera.width, view.camera.height, 1, kNoDepth);
  const RayScene scene(points, faces);
  const PixelBox box = ProjectedBounds(points, view);
  const Rigid3 world_from_camera = view.camera_from_world.Inverse();
  const Eigen::Matrix3d turn = world_from_camera.rotation.toRotationMatrix();
  const Vector3d& eye = world_from_camera.translation;
  const double height = (eye - table.origin).dot(table.up);
  // Rays have length 1 along the axis, so that distances in them are depths.
  const auto depth_along = [&](const Vector3d& ray) {
    const double down = -ray.dot(table.up);
    const double to_table =
        height > 0 && down > 0 ? height / down : std::numeric_limits<double>::infinity();
    const RayScene::Hit hit = scene.Cast(eye, ray, 0, to_table);
    const bool hidden = hit.face < 0 || (props && props->Occluded(eye, ray, 0, hit.distance));
    return hidden ? kNoDepth : static_cast<float>(hit.distance);
  };
  ParallelFor(
      box.y1 - box.y0,
      [&](std::int64_t i) {
        const int y = box.y0 + static_cast<int>(i);
        for (int x = box.x0; x < box.x1; ++x)
          for (int k = 0; k < along * along; ++k) {
            const Vector3d ray =
                turn * rays.At(x, y, (k % along + 0.5) / along, (k / along + 0.5) / along);
            *depth.at(x, y) = std::min(*depth.at(x, y), depth_along(ray));
          }
      },
      4);
  return depth;
}

}  // namespace keypose::composite
