#include "reconstruct/fusion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"

namespace keypose::reconstruct {
namespace {

struct Member {
  int view = -1;
  std::size_t pixel = 0;
};

struct Group {
  std::array<Member, kMaxSources + 1> members;
  int count = 0;
};

class Fuser {
 public:
  Fuser(const std::vector<DenseView>& views, const std::vector<std::vector<int>>& sources, const std::vector<PlaneMap>& maps,
        const FusionOptions& options)
      : views_(views),
        sources_(sources),
        maps_(maps),
        options_(options),
        least_cosine_(std::cos(options.normal_tolerance_deg * M_PI / 180)),
        confirmed_(views.size()),
        used_(views.size()) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      rotations_.push_back(views[i].camera_from_world.rotation.toRotationMatrix());
      centers_.push_back(views[i].Center());
    }
  }

  FusionResult Run() {
    ParallelFor(static_cast<std::int64_t>(views_.size()), [&](std::int64_t i) { Confirm(static_cast<int>(i)); });
    for (std::size_t i = 0; i < views_.size(); ++i) used_[i].assign(confirmed_[i].size(), 0);
    for (std::size_t i = 0; i < views_.size(); ++i) Emit(static_cast<int>(i));
    FusionResult result;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const double found = static_cast<double>(std::count(confirmed_[i].begin(), confirmed_[i].end(), 1));
      result.completeness.push_back(views_[i].masked_pixels > 0 ? found / static_cast<double>(views_[i].masked_pixels) : 0);
    }
    result.cloud = Cloud();
    result.confirmed = std::move(confirmed_);
    return result;
  }

 private:
  bool Usable(int view, std::size_t pixel) const {
    return maps_[view].InverseDepth(pixel) > 0 && maps_[view].Cost(pixel) <= options_.largest_cost;
  }
  Eigen::Vector3d World(int view, std::size_t pixel) const {
    const int x = static_cast<int>(pixel % maps_[view].width), y = static_cast<int>(pixel / maps_[view].width);
    return rotations_[view].transpose() * (views_[view].camera().Ray(x, y) / maps_[view].InverseDepth(pixel)) + centers_[view];
  }
  Eigen::Vector3d Normal(int view, std::size_t pixel) const {
    const int x = static_cast<int>(pixel % maps_[view].width), y = static_cast<int>(pixel / maps_[view].width);
    return rotations_[view].transpose() * PlaneNormal(views_[view].camera(), x, y, maps_[view].Plane(pixel));
  }

  // The pixels of the sources that show the same piece of surface; the first member is the pixel itself. Stops when there are `enough`.
  Group Agreeing(int view, std::size_t pixel, int enough) const {
    Group group;
    group.members[group.count++] = {view, pixel};
    const Eigen::Vector3d point = World(view, pixel), normal = Normal(view, pixel);
    const Eigen::Vector2d here(static_cast<double>(pixel % maps_[view].width), static_cast<double>(pixel / maps_[view].width));
    for (const int s : sources_[view]) {
      const PlaneMap& map = maps_[s];
      if (map.empty()) continue;
      const Eigen::Vector3d x = rotations_[s] * (point - centers_[s]);
      if (x.z() <= 0) continue;
      const Eigen::Vector2d p = views_[s].camera().Project(x);
      if (!(p.x() > -0.5 && p.y() > -0.5 && p.x() < map.width - 0.5 && p.y() < map.height - 0.5)) continue;
      const std::size_t other = static_cast<std::size_t>(p.y() + 0.5) * map.width + static_cast<std::size_t>(p.x() + 0.5);
      if (!Usable(s, other) || std::abs(1 - x.z() * map.InverseDepth(other)) > options_.depth_tolerance) continue;
      const Eigen::Vector3d back = rotations_[view] * (World(s, other) - centers_[view]);
      if (back.z() <= 0 || (views_[view].camera().Project(back) - here).norm() > options_.reprojection_px) continue;
      if (Normal(s, other).dot(normal) < least_cosine_) continue;
      group.members[group.count++] = {s, other};
      if (group.count >= enough) break;
    }
    return group;
  }

  void Confirm(int view) {
    const PlaneMap& map = maps_[view];
    confirmed_[view].assign(map.size(), 0);
    for (std::size_t pixel = 0; pixel < map.size(); ++pixel)
      confirmed_[view][pixel] = Usable(view, pixel) && Agreeing(view, pixel, options_.least_views).count >= options_.least_views;
  }

  void Emit(int view) {
    for (std::size_t pixel = 0; pixel < confirmed_[view].size(); ++pixel) {
      if (!confirmed_[view][pixel] || used_[view][pixel]) continue;
      const Group group = Agreeing(view, pixel, kMaxSources + 1);
      int used = 0;
      for (int k = 1; k < group.count; ++k) used += used_[group.members[k].view][group.members[k].pixel];
      if (used >= 2) continue;
      for (int k = 0; k < group.count; ++k) used_[group.members[k].view][group.members[k].pixel] = 1;
      Merge(group);
    }
  }

  // Weighted by how squarely and how closely a view sees the surface.
  void Merge(const Group& group) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = point, color = point;
    double total = 0, match = 0;
    for (int k = 0; k < group.count; ++k) {
      const auto [view, pixel] = group.members[k];
      const Eigen::Vector3d x = World(view, pixel), n = Normal(view, pixel);
      const Eigen::Vector3d to_camera = centers_[view] - x;
      const double weight = std::max(0.05, n.dot(to_camera.normalized())) / to_camera.squaredNorm();
      const std::uint8_t* rgb = views_[view].color.data.data() + pixel * 3;
      point += weight * x, normal += weight * n;
      color += weight * Eigen::Vector3d(rgb[0], rgb[1], rgb[2]);
      match += weight * std::max(0.0, 1.0 - maps_[view].Cost(pixel));
      total += weight;
    }
    points_.push_back(point / total);
    normals_.push_back(normal.normalized());
    colors_.push_back(color / total);
    const double views = std::min(1.0, (group.count - 1) / 4.0);
    confidence_.push_back(static_cast<float>(std::clamp(views * (0.3 + 0.7 * match / total), 0.05, 1.0)));
  }

  PointCloud Cloud() const {
    PointCloud cloud;
    const int count = static_cast<int>(points_.size());
    cloud.points.resize(count, 3), cloud.normals.resize(count, 3), cloud.colors.resize(count, 3), cloud.confidence.resize(count);
    for (int i = 0; i < count; ++i) {
      cloud.points.row(i) = points_[i], cloud.normals.row(i) = normals_[i];
      for (int c = 0; c < 3; ++c) cloud.colors(i, c) = static_cast<std::uint8_t>(std::lround(std::clamp(colors_[i][c], 0.0, 255.0)));
      cloud.confidence[i] = confidence_[i];
    }
    return cloud;
  }

  const std::vector<DenseView>& views_;
  const std::vector<std::vector<int>>& sources_;
  const std::vector<PlaneMap>& maps_;
  const FusionOptions& options_;
  const double least_cosine_;
  std::vector<Eigen::Matrix3d> rotations_;
  std::vector<Eigen::Vector3d> centers_;
  std::vector<std::vector<char>> confirmed_, used_;
  std::vector<Eigen::Vector3d> points_, normals_, colors_;
  std::vector<float> confidence_;
};

}  // namespace

FusionResult FuseDepthMaps(const std::vector<DenseView>& views, const std::vector<std::vector<int>>& sources,
                           const std::vector<PlaneMap>& maps, const FusionOptions& options) {
  return Fuser(views, sources, maps, options).Run();
}

}  // namespace keypose::reconstruct
