#include "core/pictures/cloud_picture.h"

#include <cmath>
#include <limits>

#include "core/pictures/render.h"

namespace keypose {
namespace {

constexpr std::uint8_t kPaper = 247;
constexpr std::uint8_t kPlainPoint = 120;
constexpr double kElevationDeg = 14;

}  // namespace

Image8 RenderCloud(const PointCloud& cloud, const View& view) {
  const int width = view.camera.width, height = view.camera.height;
  Image8 picture(width, height, 3, kPaper);
  ImageF depth(width, height, 1, std::numeric_limits<float>::infinity());
  for (Eigen::Index i = 0; i < cloud.points.rows(); ++i) {
    const Eigen::Vector3d x = view.camera_from_world * cloud.points.row(i).transpose();
    const Eigen::Vector2d corner = view.camera.Project(x).array() - 0.5;
    const float z = static_cast<float>(x.z());
    for (int k = 0; k < 4; ++k) {
      const int px = static_cast<int>(std::floor(corner.x())) + k % 2;
      const int py = static_cast<int>(std::floor(corner.y())) + k / 2;
      const bool inside = px >= 0 && py >= 0 && px < width && py < height;
      if (!inside || z >= *depth.at(px, py)) continue;
      *depth.at(px, py) = z;
      for (int c = 0; c < 3; ++c)
        picture.at(px, py)[c] = cloud.colors.rows() > 0 ? cloud.colors(i, c) : kPlainPoint;
    }
  }
  return picture;
}

Image8 RenderCloudSides(const PointCloud& cloud, int width, int height) {
  std::vector<Image8> sides;
  for (const double azimuth_deg : {20.0, 110.0, 200.0, 290.0})
    sides.push_back(
        RenderCloud(cloud, FitView(cloud.points, azimuth_deg, kElevationDeg, width, height)));
  return TileImages(sides, 4);
}

}  // namespace keypose
