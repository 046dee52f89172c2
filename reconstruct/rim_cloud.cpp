#include "reconstruct/rim_cloud.h"

#include <algorithm>
#include <cmath>

#include "core/kd_tree.h"
#include "core/parallel.h"
#include "reconstruct/cloud_rows.h"

namespace keypose::reconstruct {
namespace {

constexpr int kNeighbors = 8;
constexpr double kLeastFacing = 0.5;  // cosine between a point's normal and a rim's
constexpr double kInsideRim = 2;         // pixels from the rim to where the figure's colour is read
constexpr int kGrain = 1024;

// What rim points say of a place.
struct RimVerdict {
  int agreed = 0, contradicted = 0;
};

RimVerdict Ask(const std::vector<RimPoint>& rims, const std::vector<KdTree::Neighbor>& near, const Eigen::Vector3d& point,
            const Eigen::Vector3d& normal, const RimCloudOptions& options) {
  RimVerdict verdict;
  for (const KdTree::Neighbor& neighbor : near) {
    const RimPoint& rim = rims[neighbor.index];
    if (rim.normal.dot(normal) < kLeastFacing) continue;
    const Eigen::Vector3d way = point - rim.point;
    const double height = way.dot(rim.normal), beside = (way - height * rim.normal).norm();
    if (beside > options.beside_px * rim.footprint || std::abs(height) > options.reach_px * rim.footprint) continue;
    verdict.agreed += std::abs(height) <= options.agrees_px * rim.footprint;
    verdict.contradicted += std::abs(height) > options.errs_px * rim.footprint;
  }
  return verdict;
}

Eigen::RowVector3d ColorInside(const RimPoint& rim, const DenseView& view) {
  const Eigen::Vector2d pixel = view.camera().Project(view.camera_from_world * (rim.point - kInsideRim * rim.footprint * rim.normal));
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, view.color.width - 1);
  const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, view.color.height - 1);
  const std::uint8_t* rgb = view.color.at(x, y);
  return {static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2])};
}

}  // namespace

int DropWhatRimsContradict(const std::vector<RimPoint>& rims, const RimCloudOptions& options, PointCloud* cloud) {
  if (rims.empty()) return 0;
  PointsX3 places(rims.size(), 3);
  for (std::size_t i = 0; i < rims.size(); ++i) places.row(static_cast<int>(i)) = rims[i].point;
  const KdTree tree(places);
  std::vector<char> keep(cloud->points.rows(), 1);
  ParallelFor(
      cloud->points.rows(),
      [&](std::int64_t i) {
        const RimVerdict verdict =
            Ask(rims, tree.Nearest(cloud->points.row(i), kNeighbors), cloud->points.row(i), cloud->normals.row(i), options);
        keep[i] = verdict.agreed > 0 || verdict.contradicted < options.witnesses;
      },
      kGrain);
  return KeepRows(keep, cloud);
}

PointCloud RimCloud(const std::vector<RimPoint>& rims, const std::vector<DenseView>& views) {
  PointCloud cloud;
  const auto count = static_cast<Eigen::Index>(rims.size());
  cloud.points.resize(count, 3), cloud.normals.resize(count, 3), cloud.colors.resize(count, 3);
  cloud.confidence.setOnes(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const RimPoint& rim = rims[static_cast<std::size_t>(i)];
    cloud.points.row(i) = rim.point;
    cloud.normals.row(i) = rim.normal;
    cloud.colors.row(i) = ColorInside(rim, views[static_cast<std::size_t>(rim.view)]).cast<std::uint8_t>();
  }
  return cloud;
}

}  // namespace keypose::reconstruct
