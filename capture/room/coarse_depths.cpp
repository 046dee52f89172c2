#include "capture/room/coarse_depths.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"
#include "views/stereo/patch_match.h"

namespace keypose::capture {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr int kLevels = 3;
constexpr int kSameLevels = 6;    // of three colours together: windows that differ by no more
constexpr double kNearest = 0.2;  // of a camera's distance: nothing is nearer
// Angles between views at the middle [deg], as views/hull/view_selection.cpp has them.
constexpr double kLeastAngle = 3, kBestAngle = 12, kMostAngle = 50, kBelow = 5, kAbove = 15;

double MedianDistance(const std::vector<View>& views, const Vector3d& middle) {
  std::vector<double> distances;
  for (const View& view : views) distances.push_back((view.Center() - middle).norm());
  return UpperMedian(std::move(distances));
}

/// The pixels whose rays pass the middle within reach.
Image8 LooksNear(const View& view, const Vector3d& middle, double reach) {
  Image8 mask(view.camera.width, view.camera.height, 1, 0);
  const Vector3d center = view.camera_from_world * middle;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const Vector3d ray = view.camera.Unproject(Vector2d(x + 0.5, y + 0.5)).normalized();
      if (ray.cross(center).norm() < reach && ray.dot(center) > 0) *mask.at(x, y) = 255;
    }
  return mask;
}

/// From a little before the camera to far behind the figure.
DepthBounds BoundsOf(const PreparedView& view, const Vector3d& middle, double farthest) {
  const int level = SizeOf(view.levels) - 1;
  const Pinhole& camera = view.camera(level);
  const double depth = (view.camera_from_world * middle).z();
  DepthBounds bounds{level, ImageF(camera.width, camera.height, 1),
                     ImageF(camera.width, camera.height, 1),
                     ImageF(camera.width, camera.height, 2)};
  std::fill(bounds.nearest.data.begin(), bounds.nearest.data.end(),
            static_cast<float>(1 / (kNearest * depth)));
  std::fill(bounds.farthest.data.begin(), bounds.farthest.data.end(),
            static_cast<float>(1 / (farthest * depth)));
  return bounds;
}

struct Prepared {
  std::vector<PreparedView> views;  ///< those that look at the middle
  std::vector<int> index;           ///< of each, among all views
};

Prepared Prepare(const std::vector<Image8>& images, const Scene& scene, const Vector3d& middle,
                 double reach, const CoarseDepthOptions& options) {
  std::vector<PreparedView> all(images.size());
  ParallelFor(std::ssize(images), [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    const View& view = scene.views[v];
    if ((view.camera_from_world * middle).z() <= 0) return;
    const int longer = std::max(images[v].width, images[v].height);
    const double scale = std::min(1.0, static_cast<double>(options.longer_px) / longer);
    all[v] = PrepareView(view, static_cast<int>(v), images[v], LooksNear(view, middle, reach),
                         scale, kLevels);
  });
  Prepared prepared;
  for (std::size_t v = 0; v < all.size(); ++v) {
    if (all[v].masked_pixels == 0) continue;
    prepared.views.push_back(std::move(all[v]));
    prepared.index.push_back(static_cast<int>(v));
  }
  return prepared;
}

std::vector<std::vector<Vector3d>> SeedsOf(const Prepared& prepared, const Scene& scene) {
  std::vector<std::vector<Vector3d>> of_scene(scene.views.size()), seeds;
  for (const SparsePoint& point : scene.points)
    for (const int v : point.views) of_scene[static_cast<std::size_t>(v)].push_back(point.position);
  for (const int v : prepared.index) seeds.push_back(of_scene[static_cast<std::size_t>(v)]);
  return seeds;
}

/// How well two views show what is near the middle together: best at 12 degrees, as deep as wide.
double PairScore(const PreparedView& view, const PreparedView& other, const Vector3d& middle) {
  const Vector3d from = view.Center() - middle, to = other.Center() - middle;
  const double degrees =
      std::acos(std::clamp(from.normalized().dot(to.normalized()), -1.0, 1.0)) * 180 / M_PI;
  if (degrees < kLeastAngle || degrees > kMostAngle) return 0;
  const double off = (degrees - kBestAngle) / (degrees < kBestAngle ? kBelow : kAbove);
  const double scale = (view.camera().fx / from.norm()) / (other.camera().fx / to.norm());
  return std::exp(-0.5 * off * off) * std::min(scale, 1 / scale);
}

/// For each view the others that match best, where there are two or more.
std::vector<std::vector<int>> SourcesOf(const std::vector<PreparedView>& views,
                                        const Vector3d& middle, int count) {
  std::vector<std::vector<int>> sources(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<std::pair<double, int>> scores;
    for (std::size_t o = 0; o < views.size(); ++o)
      if (const double score = o == v ? 0 : PairScore(views[v], views[o], middle); score > 0)
        scores.emplace_back(-score, static_cast<int>(o));
    std::sort(scores.begin(), scores.end());
    if (scores.size() < 2) continue;
    for (std::size_t k = 0; k < scores.size() && SizeOf(sources[v]) < count; ++k)
      sources[v].push_back(scores[k].second);
  }
  return sources;
}

/// Depths of one view at places that other views ask for.
class DepthMaps {
 public:
  DepthMaps(const std::vector<PreparedView>& views, const std::vector<stereo::PlaneMap>& maps,
            const CoarseDepthOptions& options)
      : views_(views), maps_(maps), options_(options) {}

  /// Nothing where no window matches well.
  double Depth(std::size_t view, std::size_t pixel, stereo::PlaneHypothesis* plane) const {
    const stereo::PlaneMap& map = maps_[view];
    if (map.empty()) return 0;
    const std::size_t place = map.Find(pixel);
    if (place == stereo::PlaneMap::kNone || map.Cost(place) > options_.sure_cost) return 0;
    *plane = map.Plane(place);
    return 1 / plane->inverse_depth;
  }

  bool Confirms(std::size_t view, const Vector3d& point) const {
    const Pinhole& camera = views_[view].camera();
    const Vector3d x = views_[view].camera_from_world * point;
    if (x.z() <= 0) return false;
    const Vector2d p = camera.Project(x);
    const int px = static_cast<int>(std::lround(p.x())), py = static_cast<int>(std::lround(p.y()));
    if (px < 0 || py < 0 || px >= camera.width || py >= camera.height) return false;
    stereo::PlaneHypothesis plane;
    const double depth = Depth(view, static_cast<std::size_t>(py) * camera.width + px, &plane);
    return depth > 0 && std::abs(depth - x.z()) < options_.agrees * x.z();
  }

 private:
  const std::vector<PreparedView>& views_;
  const std::vector<stereo::PlaneMap>& maps_;
  const CoarseDepthOptions& options_;
};

/// Mean difference of two windows, grey levels times 3; large where one is not in its picture.
int Difference(const Image8& a, const Eigen::Vector2i& in_a, const Image8& b,
               const Eigen::Vector2i& in_b) {
  constexpr int kReach = 3, kBeyond = 1 << 20;
  for (const auto& [image, at] : {std::pair{&a, in_a}, std::pair{&b, in_b}})
    if (at.x() < kReach || at.y() < kReach || at.x() >= image->width - kReach ||
        at.y() >= image->height - kReach)
      return kBeyond;
  int sum = 0;
  for (int dy = -kReach; dy <= kReach; ++dy)
    for (int dx = -kReach; dx <= kReach; ++dx) {
      const std::uint8_t* p = a.at(in_a.x() + dx, in_a.y() + dy);
      const std::uint8_t* q = b.at(in_b.x() + dx, in_b.y() + dy);
      for (int c = 0; c < 3; ++c) sum += std::abs(p[c] - q[c]);
    }
  return sum / ((2 * kReach + 1) * (2 * kReach + 1));
}

/// What two photographs of one size show of a point.
struct TwoSights {
  const Image8 &image, &other_image;
  const View &view, &other;
};

/// Whether a match is explained as well by what stands still in the picture. Before a tripod, a
/// wall that stands still behind a turntable matches itself as if it were on the turntable's axis,
/// where points hardly move.
bool MayStandStill(const TwoSights& sights, const Vector3d& point, double near_axis_px) {
  if (sights.image.width != sights.other_image.width) return false;
  const Vector2d here = sights.view.Project(point), there = sights.other.Project(point);
  if ((here - there).norm() > near_axis_px) return false;
  const auto pixel = [](const Vector2d& p) -> Eigen::Vector2i {
    return p.array().floor().cast<int>();
  };
  const int moved = Difference(sights.image, pixel(here), sights.other_image, pixel(there)),
            still = Difference(sights.image, pixel(here), sights.other_image, pixel(here));
  return still <= moved + kSameLevels;
}

std::vector<DepthSample> SamplesOf(const Prepared& prepared, std::size_t view,
                                   const std::vector<int>& sources, const DepthMaps& maps,
                                   const std::vector<Image8>& images,
                                   const std::vector<View>& photographs,
                                   const CoarseDepthOptions& options) {
  std::vector<DepthSample> samples;
  const PreparedView& own = prepared.views[view];
  const Pinhole& camera = own.camera();
  const Rigid3 world_from_camera = own.camera_from_world.Inverse();
  const auto index = [&](std::size_t of) { return static_cast<std::size_t>(prepared.index[of]); };
  const std::size_t here = index(view);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      stereo::PlaneHypothesis plane;
      const double depth = maps.Depth(view, static_cast<std::size_t>(y) * camera.width + x, &plane);
      if (depth <= 0) continue;
      const Vector3d point = world_from_camera * (depth * camera.Ray(x, y));
      const auto agreeing = std::count_if(sources.begin(), sources.end(), [&](int source) {
        const auto other = static_cast<std::size_t>(source);
        return maps.Confirms(other, point) &&
               !MayStandStill({images[here], images[index(other)], photographs[here],
                               photographs[index(other)]},
                              point, options.near_axis_px);
      });
      if (agreeing < options.confirming) continue;
      const Vector3d outward = world_from_camera.rotation * PlaneNormal(camera, x, y, plane);
      const std::uint8_t* rgb = own.color.at(x, y);
      samples.push_back({photographs[here].Project(point), point, outward.cast<float>(),
                         Eigen::Vector3f(rgb[0], rgb[1], rgb[2])});
    }
  return samples;
}

}  // namespace

CoarseDepths FindCoarseDepths(const std::vector<Image8>& images, const Scene& scene,
                              const Vector3d& middle, const CoarseDepthOptions& options,
                              Progress* progress) {
  CoarseDepths depths;
  depths.views.resize(images.size());
  depths.distance = MedianDistance(scene.views, middle);
  const Prepared prepared =
      Prepare(images, scene, middle, options.reach * depths.distance, options);
  const std::vector<PreparedView>& views = prepared.views;
  if (views.size() < 3) return depths;
  for (const Image8& image : images)
    depths.pixel = std::max(
        depths.pixel, static_cast<double>(std::max(image.width, image.height)) / options.longer_px);
  std::vector<DepthBounds> bounds;
  for (const PreparedView& view : views) bounds.push_back(BoundsOf(view, middle, options.farthest));
  const std::vector<std::vector<int>> sources = SourcesOf(views, middle, options.sources);
  stereo::PatchMatchOptions matching;
  matching.geometric_passes = 1;
  const stereo::PatchMatchResult planes =
      EstimatePlanes(views, sources, bounds, SeedsOf(prepared, scene), matching, progress);
  const DepthMaps maps(views, planes.maps, options);
  ParallelFor(std::ssize(views), [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    const auto at = static_cast<std::size_t>(prepared.index[v]);
    depths.views[at] = SamplesOf(prepared, v, sources[v], maps, images, scene.views, options);
  });
  return depths;
}

}  // namespace keypose::capture
