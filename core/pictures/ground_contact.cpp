#include "core/pictures/ground_contact.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostViews = 48;
constexpr double kShareAgainst =
    1.0 / 16;                    // of the views: this many masks may lack a part of the figure
constexpr double kDown = 0.05;   // slope from which on a ray looks down
constexpr int kRimPixels = 300;  // used of each view, approximately
constexpr int kRaySteps = 160;   // along the part of a ray near the ground
constexpr int kHalvings = 6;
// of the box's height: the ground is searched this far above and below its lower side
constexpr double kReach = 0.3;
constexpr double kCrowd = 0.0075;  // of the box's height: entry points this close together ...
constexpr double kCrowdShare =
    0.1;  // ... that are this share of a view's are not caused by mask errors
constexpr std::size_t kCrowdPixels = 4;
constexpr std::size_t kFewestViews = 3;
// slopes must differ by this much to show how round the sole's edge is
constexpr double kOtherRing = 0.15;
// of the box's height: half of the value of round feet, because sharp edges have 0
constexpr double kUsualRise = 0.01;

struct Outline {
  View view;  // of the mask's size
  const Image8* mask;
};

/// Where one ray, or the rays of one view, first meet the figure.
struct Met {
  double height;
  double slope;  // of the ray, downwards
};

std::vector<Outline> Outlines(const std::vector<View>& views, const std::vector<Image8>& masks) {
  std::vector<Outline> all, some;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (masks[i].empty()) continue;
    all.push_back({views[i], &masks[i]});
    all.back().view.camera =
        views[i].camera.Scaled(static_cast<double>(masks[i].width) / views[i].camera.width);
  }
  const std::size_t step = std::max<std::size_t>(1, (all.size() + kMostViews - 1) / kMostViews);
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

/// Whether a view allows the figure at x: it projects into the mask or outside of the photograph.
bool Allows(const Outline& outline, const Vector3d& x) {
  const Vector3d in_camera = outline.view.camera_from_world * x;
  if (!(in_camera.z() > 0)) return true;
  const Vector2d pixel = outline.view.camera.Project(in_camera);
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < outline.mask->width &&
        pixel.y() < outline.mask->height))
    return true;
  return *outline.mask->at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())) > 127;
}

/// @param own  the outline that the point's ray comes from; its mask is not tested
bool InHull(const std::vector<Outline>& outlines, const Outline& own, const Vector3d& x) {
  int left = static_cast<int>(kShareAgainst * static_cast<double>(outlines.size()));
  for (const Outline& outline : outlines)
    if (&outline != &own && !Allows(outline, x) && --left < 0) return false;
  return true;
}

/// The figure's pixels that have background directly below them.
std::vector<Vector2d> LowerRim(const Outline& outline, const Vector3d& middle) {
  const View& view = outline.view;
  const double far = (view.Center() - middle).norm();
  const Vector2d down =
      view.Project(middle - 0.01 * far * Vector3d::UnitZ()) - view.Project(middle);
  const bool upright = std::abs(down.y()) >= std::abs(down.x());
  const int dx = upright ? 0 : (down.x() > 0 ? 1 : -1), dy = upright ? (down.y() > 0 ? 1 : -1) : 0;
  const Image8& mask = *outline.mask;
  std::vector<Vector2d> rim, few;
  for (int y = 1; y + 1 < mask.height; ++y)
    for (int x = 1; x + 1 < mask.width; ++x)
      if (*mask.at(x, y) > 127 && *mask.at(x + dx, y + dy) <= 127)
        rim.emplace_back(x + 0.5, y + 0.5);
  const std::size_t step = rim.size() / kRimPixels + 1;
  for (std::size_t i = 0; i < rim.size(); i += step) few.push_back(rim[i]);
  return few;
}

/// Where the ray first enters the visual hull between two heights. Nothing when it looks up, misses
/// the hull, or is inside of it at the upper height already.
std::optional<Met> FirstMet(const std::vector<Outline>& outlines, const Outline& own,
                            const Vector2d& pixel, double from, double to) {
  const Vector3d origin = own.view.Center();
  const Vector3d ray =
      own.view.camera_from_world.rotation.conjugate() * own.view.camera.Unproject(pixel);
  const double slope = -ray.z() / ray.head<2>().norm();
  if (!(slope > kDown) || origin.z() < from) return std::nullopt;
  const auto at = [&](double height) {
    return Vector3d(origin + (height - origin.z()) / ray.z() * ray);
  };
  const double step = (from - to) / kRaySteps;
  int i = 0;
  while (i <= kRaySteps && !InHull(outlines, own, at(from - i * step))) ++i;
  if (i == 0 || i > kRaySteps) return std::nullopt;
  double outside = from - (i - 1) * step, inside = from - i * step;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = (outside + inside) / 2;
    (InHull(outlines, own, at(middle)) ? inside : outside) = middle;
  }
  // The outline is half a pixel below the centre of the last pixel.
  const double pixel_size = (own.view.camera_from_world * at(inside)).z() / own.view.camera.fy;
  return Met{inside - 0.5 * pixel_size * std::sqrt(1 + slope * slope), slope};
}

/// The lowest height at which enough entry points lie within `width`.
std::optional<Met> LowestCrowd(std::vector<Met> met, double width) {
  std::sort(met.begin(), met.end(), [](const Met& a, const Met& b) { return a.height < b.height; });
  const std::size_t enough = std::max(
      kCrowdPixels, static_cast<std::size_t>(kCrowdShare * static_cast<double>(met.size())));
  for (std::size_t i = 0; i + enough <= met.size(); ++i)
    if (met[i + enough - 1].height - met[i].height < width) return met[i + enough / 2];
  return std::nullopt;
}

/// By how much the seen height rises per unit of slope. The visible end of a sole with a round edge
/// is where the edge is as steep as the ray: higher for higher cameras. Median over all pairs
/// (Theil 1950, Sen 1968).
/// @param usual  result when all views have about the same slope
double RiseOf(const std::vector<Met>& views, double usual) {
  std::vector<double> rises;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = views[i].slope - views[j].slope;
      if (std::abs(apart) > kOtherRing)
        rises.push_back((views[i].height - views[j].height) / apart);
    }
  return rises.size() < kFewestViews ? usual : std::max(0.0, UpperMedian(rises));
}

}  // namespace

std::optional<GroundContact> FindGroundContact(const std::vector<View>& views,
                                               const std::vector<Image8>& masks,
                                               const Vector3d& low, const Vector3d& high) {
  const std::vector<Outline> outlines = Outlines(views, masks);
  const double tall = high.z() - low.z();
  std::vector<std::optional<Met>> of_view(outlines.size());
  ParallelFor(std::ssize(outlines), [&](std::int64_t v) {
    const Outline& outline = outlines[v];
    std::vector<Met> rim;
    for (const Vector2d& pixel : LowerRim(outline, (low + high) / 2))
      if (const auto met =
              FirstMet(outlines, outline, pixel, low.z() + kReach * tall, low.z() - kReach * tall))
        rim.push_back(*met);
    of_view[v] = LowestCrowd(std::move(rim), kCrowd * tall);
  });
  std::vector<Met> lowest;
  for (const auto& met : of_view)
    if (met) lowest.push_back(*met);
  if (lowest.size() < kFewestViews) return std::nullopt;
  const double rise = RiseOf(lowest, kUsualRise * tall);
  std::vector<double> heights;
  for (const Met& met : lowest) heights.push_back(met.height - rise * met.slope);
  GroundContact contact;
  contact.height = UpperMedian(heights);
  contact.views = SizeOf(heights);
  for (double& height : heights) height = std::abs(height - contact.height);
  contact.spread = UpperMedian(std::move(heights));
  return contact;
}

}  // namespace keypose
