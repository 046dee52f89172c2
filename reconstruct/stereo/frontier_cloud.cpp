#include "reconstruct/stereo/frontier_cloud.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "reconstruct/cloud/cloud_rows.h"

namespace keypose::reconstruct {
namespace {

constexpr int kNeighbors = 8;
constexpr double kLeastFacing = 0.5;  // cosine between a point's normal and a frontier point's
// distance from the outline at which the figure's colour is read, pixels
constexpr double kInsideOutline = 2;
constexpr int kGrain = 1024;

// Numbers of frontier points that are consistent or inconsistent with a point.
struct FrontierVerdict {
  int agreed = 0, contradicted = 0;
};

FrontierVerdict Ask(const std::vector<FrontierPoint>& frontier,
                    const std::vector<KdTree::Neighbor>& near, const Eigen::Vector3d& point,
                    const Eigen::Vector3d& normal, const FrontierCloudOptions& options) {
  FrontierVerdict verdict;
  for (const KdTree::Neighbor& neighbor : near) {
    const FrontierPoint& touch = frontier[neighbor.index];
    if (touch.normal.dot(normal) < kLeastFacing) continue;
    const Eigen::Vector3d way = point - touch.point;
    const double height = way.dot(touch.normal), beside = (way - height * touch.normal).norm();
    if (beside > options.beside_px * touch.footprint ||
        std::abs(height) > options.reach_px * touch.footprint)
      continue;
    verdict.agreed += std::abs(height) <= options.agrees_px * touch.footprint;
    verdict.contradicted += std::abs(height) > options.errs_px * touch.footprint;
  }
  return verdict;
}

Eigen::RowVector3d ColorInside(const FrontierPoint& touch, const PreparedView& view) {
  const Eigen::Vector2d pixel = view.camera().Project(
      view.camera_from_world * (touch.point - kInsideOutline * touch.footprint * touch.normal));
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, view.color.width - 1);
  const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, view.color.height - 1);
  const std::uint8_t* rgb = view.color.at(x, y);
  return {static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2])};
}

}  // namespace

int DropWhatFrontierPointsContradict(const std::vector<FrontierPoint>& frontier,
                                     const FrontierCloudOptions& options, PointCloud* cloud) {
  if (frontier.empty()) return 0;
  PointsX3 places(frontier.size(), 3);
  for (std::size_t i = 0; i < frontier.size(); ++i)
    places.row(static_cast<int>(i)) = frontier[i].point;
  const KdTree tree(places);
  std::vector<char> keep(cloud->points.rows(), 1);
  ParallelFor(
      cloud->points.rows(),
      [&](std::int64_t i) {
        const FrontierVerdict verdict =
            Ask(frontier, tree.Nearest(cloud->points.row(i), kNeighbors), cloud->points.row(i),
                cloud->normals.row(i), options);
        keep[i] = verdict.agreed > 0 || verdict.contradicted < options.contradictions;
      },
      kGrain);
  return KeepRows(keep, cloud);
}

PointCloud FrontierCloud(const std::vector<FrontierPoint>& frontier,
                         const std::vector<PreparedView>& views) {
  PointCloud cloud;
  const auto count = std::ssize(frontier);
  cloud.points.resize(count, 3);
  cloud.normals.resize(count, 3);
  cloud.colors.resize(count, 3);
  cloud.confidence.setOnes(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const FrontierPoint& touch = frontier[i];
    cloud.points.row(i) = touch.point;
    cloud.normals.row(i) = touch.normal;
    cloud.colors.row(i) = ColorInside(touch, views[touch.view]).cast<std::uint8_t>();
  }
  return cloud;
}

}  // namespace keypose::reconstruct
