#include "reconstruct/turntable/ring_tracks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/values/size_of.h"
#include "core/values/union_find.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

/// Union-find over the features of all images.
class Union {
 public:
  explicit Union(const std::vector<Features>& features) {
    for (const Features& f : features) {
      first_.push_back(count_);
      count_ += f.count();
    }
    joined_ = UnionFind(count_);
  }
  int Id(int image, std::uint32_t feature) const {
    return first_[image] + static_cast<int>(feature);
  }
  int Root(int id) { return joined_.Find(id); }
  void Join(int a, int b) { joined_.Join(a, b); }
  Track::Element Element(int id) const {
    const auto image = std::upper_bound(first_.begin(), first_.end(), id) - first_.begin() - 1;
    return {static_cast<int>(image), static_cast<std::uint32_t>(id - first_[image])};
  }

 private:
  std::vector<int> first_;
  int count_ = 0;
  UnionFind joined_{0};
};

struct Ray {
  Vector3d from, along;
};

/// The point with the least sum of squared distances to the rays.
Vector3d NearestToRays(const std::vector<Ray>& rays) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (const Ray& ray : rays) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray.along * ray.along.transpose();
    a += across;
    b += across * ray.from;
  }
  return a.ldlt().solve(b);
}

double WidestAngle(const std::vector<Ray>& rays) {
  double least = 1;
  for (std::size_t i = 0; i < rays.size(); ++i)
    for (std::size_t j = i + 1; j < rays.size(); ++j)
      least = std::min(least, rays[i].along.dot(rays[j].along));
  return std::acos(std::clamp(least, -1.0, 1.0));
}

}  // namespace

std::vector<Track> BuildTracks(const std::vector<PairMatches>& matches,
                               const std::vector<Features>& features) {
  Union together(features);
  std::vector<int> used;
  for (const PairMatches& pair : matches)
    for (const auto& [i, j] : pair.features) {
      const int a = together.Id(pair.first, i), b = together.Id(pair.second, j);
      together.Join(a, b);
      used.push_back(a);
      used.push_back(b);
    }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::map<int, Track> by_root;
  for (const int id : used) by_root[together.Root(id)].elements.push_back(together.Element(id));
  std::vector<Track> tracks;
  for (auto& [root, track] : by_root) {
    std::map<int, int> count;
    for (const Track::Element& e : track.elements) ++count[e.image];
    std::erase_if(track.elements, [&](const Track::Element& e) { return count[e.image] > 1; });
    if (track.elements.size() >= 2) tracks.push_back(std::move(track));
  }
  return tracks;
}

Triangulated Triangulate(const Scene& scene, const std::vector<int>& view_of_image,
                         const std::vector<Track>& tracks, const std::vector<Features>& features,
                         const TriangulationOptions& options) {
  Triangulated result;
  result.scene.views = scene.views;
  for (const Track& track : tracks) {
    std::vector<Observation> seen;
    std::vector<Ray> rays;
    for (const Track::Element& e : track.elements) {
      const int v = view_of_image[e.image];
      if (v < 0) continue;
      const View& view = scene.views[v];
      const Eigen::Vector2d pixel =
          features[e.image].positions.row(e.feature).transpose().cast<double>();
      seen.push_back({v, SizeOf(result.scene.points), pixel});
      rays.push_back({view.Center(),
                      (view.camera_from_world.rotation.conjugate() * view.camera.Unproject(pixel))
                          .normalized()});
    }
    // Two rounds: the second without the outlier rays of the first.
    SparsePoint point;
    for (int round = 0; round < 2 && seen.size() >= 2; ++round) {
      if (WidestAngle(rays) < options.min_angle_deg * 3.14159265358979323846 / 180) seen.clear();
      if (seen.empty()) break;
      point.position = NearestToRays(rays);
      std::vector<Observation> kept;
      std::vector<Ray> kept_rays;
      for (std::size_t k = 0; k < seen.size(); ++k) {
        const View& view = scene.views[seen[k].view];
        const Vector3d x = view.camera_from_world * point.position;
        if (x.z() > 0 && (view.camera.Project(x) - seen[k].pixel).norm() <= options.max_error_px) {
          kept.push_back(seen[k]);
          kept_rays.push_back(rays[k]);
        }
      }
      seen = std::move(kept);
      rays = std::move(kept_rays);
    }
    if (seen.size() < 2) continue;
    for (const Observation& o : seen) point.views.push_back(o.view);
    std::sort(point.views.begin(), point.views.end());
    point.color.setConstant(160);
    result.scene.points.push_back(point);
    result.observations.insert(result.observations.end(), seen.begin(), seen.end());
  }
  return result;
}

}  // namespace keypose::reconstruct
