#include "report/missing_part.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/geometry.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "report/limits.h"

namespace keypose::report {
namespace {

bool Set(const Image8& image, int x, int y) {
  return x >= 0 && y >= 0 && x < image.width && y < image.height && *image.at(x, y) >= 128;
}

/// Sets each pixel to the least (or largest) of those within `reach` along the rows; beyond the
/// picture is as the picture's border.
Image8 AlongRows(const Image8& image, int reach, bool least) {
  Image8 out(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const int from = std::max(0, x - reach), to = std::min(image.width - 1, x + reach);
      const std::uint8_t* row = image.at(from, y);
      *out.at(x, y) = least ? *std::min_element(row, row + to - from + 1)
                            : *std::max_element(row, row + to - from + 1);
    }
  return out;
}

Image8 Turned(const Image8& image) {
  Image8 out(image.height, image.width, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) *out.at(y, x) = *image.at(x, y);
  return out;
}

Image8 Squared(const Image8& image, int reach, bool least) {
  return Turned(AlongRows(Turned(AlongRows(image, reach, least)), reach, least));
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
  return Squared(Squared(missing, reach, true), reach, false);
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
      fewest = SizeOf(outside), places = 0;
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

}  // namespace

double MissingShare(const CoveredMask& view) {
  const long area = CountOf(view.mask);
  return area == 0 ? 0 : static_cast<double>(CountOf(Missing(view))) / static_cast<double>(area);
}

MissingPart FindMissingPart(const std::vector<CoveredMask>& views, const PointsX3& points) {
  std::vector<double> shares(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t v) { shares[v] = MissingShare(views[v]); });
  MissingPart part;
  part.shown_by = Above(shares, kMissingLook);
  if (SizeOf(part.shown_by) < 2) return {};
  part.largest = shares[part.shown_by.front()];
  part.left_out_by = LeftOutBy(views, part.shown_by.front(), AroundOf(points));
  return part;
}

}  // namespace keypose::report
