#include "report/evidence/missing_part.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "report/evidence/verdict_limits.h"

namespace keypose::report {
namespace {

bool Set(const Image8& image, int x, int y) {
  return x >= 0 && y >= 0 && x < image.width && y < image.height && *image.at(x, y) >= 128;
}

/// Pixels of the mask that are not covered, opened by a square: without thin rims.
Image8 Missing(const CoveredMask& view) {
  constexpr double kRim = 0.007;  // of the figure's size in the picture
  Image8 missing(view.mask.width, view.mask.height, 1);
  long area = 0;
  for (std::size_t i = 0; i < missing.data.size(); ++i) {
    const bool inside = view.mask.data[i] >= 128;
    area += inside;
    missing.data[i] = inside && view.covered.data[i] < 128 ? 255 : 0;
  }
  const int reach =
      std::max(1, static_cast<int>(std::lround(kRim * std::sqrt(2.0 * static_cast<double>(area)))));
  cv::Mat pixels(missing.height, missing.width, CV_8U, missing.data.data());
  cv::morphologyEx(pixels, pixels, cv::MORPH_OPEN, cv::Mat1b::ones(2 * reach + 1, 2 * reach + 1));
  return missing;
}

long CountOf(const Image8& image) {
  return std::count_if(image.data.begin(), image.data.end(), [](int v) { return v >= 128; });
}

enum class Sample { kUnseen, kInside, kOutside };

Sample SampleOf(const CoveredMask& view, const Eigen::Vector3d& x) {
  const Eigen::Vector3d in_camera = view.view.camera_from_world * x;
  if (in_camera.z() <= 0) return Sample::kUnseen;
  const Eigen::Vector2d pixel = view.view.camera.Project(in_camera);
  const int px = static_cast<int>(std::floor(pixel.x())),
            py = static_cast<int>(std::floor(pixel.y()));
  if (px < 0 || py < 0 || px >= view.mask.width || py >= view.mask.height) return Sample::kUnseen;
  return Set(view.mask, px, py) ? Sample::kInside : Sample::kOutside;
}

/// Where the figure may be: a ball around the mesh, larger than it, as the mesh lacks a part.
struct Ball {
  Eigen::Vector3d middle;
  double radius;
};

Ball AroundOf(const PointsX3& points) {
  const Eigen::Vector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  return {0.5 * (low + high), 0.75 * (high - low).norm()};
}

/// Along a pixel's ray, the places that half of the photographs see, at least one other mask shows
/// and fewest contradict.
/// @return of each view, the share of these places that it contradicts
std::vector<double> ContradictedBy(const std::vector<CoveredMask>& views, int from,
                                   const Eigen::Vector2d& pixel, const Ball& ball) {
  constexpr int kSteps = 160;
  const View& view = views[from].view;
  const Eigen::Vector3d eye = view.Center();
  const Eigen::Vector3d along =
      (view.camera_from_world.rotation.conjugate() * view.camera.Unproject(pixel)).normalized();
  const double middle = (ball.middle - eye).dot(along);
  int fewest = SizeOf(views), places = 0;
  std::vector<double> shares(views.size(), 0.0);
  std::vector<int> outside;
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Vector3d x = eye + (middle + ball.radius * (2.0 * (i + 0.5) / kSteps - 1)) * along;
    outside.clear();
    int inside = 0;
    for (int v = 0; v < SizeOf(views); ++v) {
      if (v == from) continue;
      const Sample sample = SampleOf(views[v], x);
      if (sample == Sample::kOutside) outside.push_back(v);
      inside += sample == Sample::kInside;
    }
    const bool seen_by_few = 2 * (inside + SizeOf(outside)) < SizeOf(views);
    if (inside == 0 || seen_by_few || SizeOf(outside) > fewest) continue;
    if (SizeOf(outside) < fewest) {
      fewest = SizeOf(outside);
      places = 0;
      std::fill(shares.begin(), shares.end(), 0.0);
    }
    ++places;
    for (const int v : outside) shares[v] += 1;
  }
  for (double& share : shares) share /= std::max(1, places);
  return shares;
}

/// Indices of the values above the limit, the largest first.
std::vector<int> Above(const std::vector<double>& values, double limit) {
  std::vector<int> found;
  for (int i = 0; i < SizeOf(values); ++i)
    if (values[i] > limit) found.push_back(i);
  std::stable_sort(found.begin(), found.end(), [&](int a, int b) { return values[a] > values[b]; });
  return found;
}

std::vector<int> LeftOutBy(const std::vector<CoveredMask>& views, int from, const Ball& ball) {
  constexpr int kMostPixels = 400;
  constexpr double kMost = 0.15;  // of the missing pixels
  const Image8 missing = Missing(views[from]);
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 0; y < missing.height; ++y)
    for (int x = 0; x < missing.width; ++x)
      if (Set(missing, x, y)) pixels.emplace_back(x + 0.5, y + 0.5);
  const int step = std::max(1, SizeOf(pixels) / kMostPixels), count = SizeOf(pixels) / step;
  std::vector<std::vector<double>> shares(count);
  ParallelFor(count, [&](std::int64_t i) {
    shares[i] = ContradictedBy(views, from, pixels[i * step], ball);
  });
  std::vector<double> mean(views.size(), 0.0);
  for (const std::vector<double>& one : shares)
    for (std::size_t v = 0; v < mean.size(); ++v) mean[v] += one[v] / count;
  return Above(mean, kMost);
}

/// Share of the mask that is not covered, thin rims aside.
double MissingShare(const CoveredMask& view) {
  const long area = CountOf(view.mask);
  return area == 0 ? 0 : static_cast<double>(CountOf(Missing(view))) / static_cast<double>(area);
}

std::vector<std::string> NamesOf(const std::vector<CoveredMask>& views,
                                 const std::vector<int>& chosen) {
  std::vector<std::string> names;
  for (const int v : chosen) names.push_back(views[v].view.name);
  return names;
}

}  // namespace

MissingPart FindMissingPart(const std::vector<CoveredMask>& views, const PointsX3& points) {
  std::vector<double> shares(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t v) { shares[v] = MissingShare(views[v]); });
  const std::vector<int> shown_by = Above(shares, kMissingLook);
  if (SizeOf(shown_by) < 2) return {};
  const int most = shown_by.front();
  return {shares[most], NamesOf(views, shown_by),
          NamesOf(views, LeftOutBy(views, most, AroundOf(points)))};
}

}  // namespace keypose::report
