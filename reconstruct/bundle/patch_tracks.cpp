#include "reconstruct/bundle/patch_tracks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct PatchNormalTuning {
  KEYPOSE_TUNED(int, kNear, 16);  // nearest points to which a plane is fitted
  // cosines: between the mean directions of the views of points on one side of a limb, and between
  // a normal and its point's mean direction
  KEYPOSE_TUNED(double, kSameSide, 0.5);
  KEYPOSE_TUNED(double, kFrontal, 0.4);
  KEYPOSE_TUNED(double, kFlat, 0.3);  // largest ratio of the two smaller spreads of the points
};

ImageF Smoothed(const Image8& image, double sigma) {
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  std::vector<float> weights(static_cast<std::size_t>(2 * reach + 1));
  float sum = 0;
  for (int k = -reach; k <= reach; ++k)
    sum += weights[k + reach] = std::exp(static_cast<float>(-k * k / (2 * sigma * sigma)));
  for (float& weight : weights) weight /= sum;
  ImageF across(image.width, image.height, 1), out(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      float value = 0;
      for (int k = -reach; k <= reach; ++k)
        value += weights[k + reach] * *image.at(std::clamp(x + k, 0, image.width - 1), y);
      *across.at(x, y) = value;
    }
  for (int y = 0; y < image.height; ++y)
    for (int k = -reach; k <= reach; ++k) {
      const float weight = weights[k + reach];
      const float* from = across.at(0, std::clamp(y + k, 0, image.height - 1));
      float* to = out.at(0, y);
      for (int x = 0; x < image.width; ++x) to[x] += weight * from[x];
    }
  return out;
}

/// Catmull-Rom; the caller keeps two pixels away from the border.
float Cubic(const ImageF& image, float x, float y) {
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float u = x - static_cast<float>(ix), v = y - static_cast<float>(iy);
  const auto weights = [](float t, float* w) {
    w[0] = t * (-0.5F + t * (1 - 0.5F * t));
    w[1] = 1 + t * t * (1.5F * t - 2.5F);
    w[2] = t * (0.5F + t * (2 - 1.5F * t));
    w[3] = t * t * (0.5F * t - 0.5F);
  };
  float wx[4], wy[4], sum = 0;
  weights(u, wx);
  weights(v, wy);
  for (int r = 0; r < 4; ++r) {
    const float* row = image.at(ix - 1, iy - 1 + r);
    sum += wy[r] * (wx[0] * row[0] + wx[1] * row[1] + wx[2] * row[2] + wx[3] * row[3]);
  }
  return sum;
}

/// A square of samples at `step * (i, j)` about `center` in the image's pixels (centres at .5);
/// false when it leaves the image.
bool Sample(const ImageF& image, const Vector2d& center, const Matrix2d& step, int radius,
            std::vector<float>& values) {
  const double reach_x = radius * (std::abs(step(0, 0)) + std::abs(step(0, 1))),
               reach_y = radius * (std::abs(step(1, 0)) + std::abs(step(1, 1)));
  const double cx = center.x() - 0.5, cy = center.y() - 0.5;
  if (!(cx - reach_x >= 2 && cy - reach_y >= 2 && cx + reach_x < image.width - 3 &&
        cy + reach_y < image.height - 3))
    return false;
  values.clear();
  for (int j = -radius; j <= radius; ++j)
    for (int i = -radius; i <= radius; ++i)
      values.push_back(Cubic(image, static_cast<float>(cx + step(0, 0) * i + step(0, 1) * j),
                             static_cast<float>(cy + step(1, 0) * i + step(1, 1) * j)));
  return true;
}

/// Subtracts the mean.
/// @return squared length
double Center(std::vector<float>& values) {
  double sum = 0, squares = 0;
  for (const float value : values) sum += value;
  const auto mean = static_cast<float>(sum / static_cast<double>(values.size()));
  for (float& value : values) {
    value -= mean;
    squares += static_cast<double>(value) * value;
  }
  return squares;
}

double DotOf(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += static_cast<double>(a[k]) * b[k];
  return sum;
}

/// A patch's values, and their derivatives with respect to its position.
struct Template {
  /// without mean; the derivatives also without the component along the values
  std::vector<float> values, along_x, along_y;
  double energy = 0;
  Matrix2d information = Matrix2d::Zero();
};

std::optional<Template> Cut(const ImageF& image, const Vector2d& center, int radius) {
  Template patch;
  std::vector<float> wide;
  if (!Sample(image, center, Matrix2d::Identity(), radius + 1, wide)) return std::nullopt;
  const int side = 2 * radius + 3;
  for (int j = 1; j + 1 < side; ++j)
    for (int i = 1; i + 1 < side; ++i) {
      const std::size_t at = static_cast<std::size_t>(j * side + i);
      patch.values.push_back(wide[at]);
      patch.along_x.push_back(0.5F * (wide[at + 1] - wide[at - 1]));
      patch.along_y.push_back(0.5F * (wide[at + static_cast<std::size_t>(side)] -
                                      wide[at - static_cast<std::size_t>(side)]));
    }
  patch.energy = Center(patch.values);
  if (patch.energy <= 0) return std::nullopt;
  for (std::vector<float>* slope : {&patch.along_x, &patch.along_y}) {
    Center(*slope);
    const auto contrast = static_cast<float>(DotOf(*slope, patch.values) / patch.energy);
    for (std::size_t k = 0; k < slope->size(); ++k) (*slope)[k] -= contrast * patch.values[k];
  }
  patch.information << DotOf(patch.along_x, patch.along_x), DotOf(patch.along_x, patch.along_y),
      DotOf(patch.along_x, patch.along_y), DotOf(patch.along_y, patch.along_y);
  return patch;
}

struct FittedPlace {
  Vector2d pixel;
  double ncc = 0, sigma = 0;
};

/// Moves the patch from `start` to the best match. Nothing if it diverges or the match is bad.
std::optional<FittedPlace> Fit(const Template& patch, const ImageF& image, const Vector2d& start,
                               const Matrix2d& step, double most_shift,
                               const PatchOptions& options) {
  constexpr int kMostSteps = 15;
  constexpr double kStill_px = 0.005;
  // Neighbouring samples of a smoothed picture have correlated noise, so the effective number of
  // samples is smaller.
  const double shared = 2 * std::sqrt(3.14159265358979) * options.smoothing_px;
  const Eigen::LDLT<Matrix2d> solver(patch.information);
  const auto count = static_cast<double>(patch.values.size());
  std::vector<float> seen;
  FittedPlace place{start};
  for (int k = 0; k < kMostSteps; ++k) {
    if (!Sample(image, place.pixel, step, options.radius_px, seen)) return std::nullopt;
    const double energy = Center(seen), common = DotOf(seen, patch.values);
    if (common <= 0) return std::nullopt;
    place.ncc = common / std::sqrt(energy * patch.energy);
    const double gain = patch.energy / common;
    const Vector2d move =
        solver.solve(gain * Vector2d(DotOf(seen, patch.along_x), DotOf(seen, patch.along_y)));
    if (!move.allFinite() || move.norm() > 2 * options.most_shift_px) return std::nullopt;
    const double noise2 = std::max(0.0, gain * gain * energy - patch.energy) / (count - 4);
    place.sigma = shared * std::sqrt(noise2 * patch.information.inverse().diagonal().maxCoeff());
    place.pixel -= step * move;
    if ((place.pixel - start).norm() > most_shift) return std::nullopt;
    if (move.norm() < kStill_px) break;
    if (k + 1 == kMostSteps && move.norm() > 10 * kStill_px) return std::nullopt;
  }
  if (place.ncc < options.least_ncc || place.sigma > options.most_sigma_px) return std::nullopt;
  return place;
}

/// Unit normals of the planes through the nearest points, oriented towards the views that see each
/// point.
std::vector<Vector3d> Normals(const Scene& scene, const std::vector<Vector3d>& toward) {
  PointsX3 points(std::ssize(scene.points), 3);
  for (std::size_t p = 0; p < scene.points.size(); ++p) points.row(p) = scene.points[p].position;
  const KdTree tree(points);
  std::vector<Vector3d> normals(toward);
  ParallelFor(
      std::ssize(scene.points),
      [&](std::int64_t i) {
        const Vector3d x = points.row(i), view = toward[i];
        // Excludes points on the other side of a thin limb.
        std::vector<Vector3d> near;
        for (const auto& [index, distance] : tree.Nearest(x, 2 * PatchNormalTuning::kNear)) {
          if (toward[index].dot(view) > PatchNormalTuning::kSameSide &&
              SizeOf(near) < PatchNormalTuning::kNear)
            near.push_back(points.row(index).transpose());
        }
        if (near.size() < 6) return;
        Vector3d mean = Vector3d::Zero();
        for (const Vector3d& y : near) mean += y / static_cast<double>(near.size());
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        for (const Vector3d& y : near) spread += (y - mean) * (y - mean).transpose();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
        Vector3d normal = axes.eigenvectors().col(0);
        if (normal.dot(view) < 0) normal = -normal;
        if (normal.dot(view) > PatchNormalTuning::kFrontal &&
            axes.eigenvalues()(0) < PatchNormalTuning::kFlat * axes.eigenvalues()(1))
          normals[i] = normal;
      },
      64);
  return normals;
}

class Tracker {
 public:
  Tracker(const Scene& scene, const std::vector<PatchImage>& images, const PatchOptions& options)
      : scene_(scene), images_(images), options_(options) {
    for (const View& view : scene.views) centers_.push_back(view.Center());
    std::vector<Vector3d> toward;
    for (const SparsePoint& point : scene.points) {
      Vector3d sum = Vector3d::Zero();
      for (const int v : point.views) sum += (centers_[v] - point.position).normalized();
      toward.push_back(sum.normalized());
    }
    normals_ = Normals(scene, toward);
  }

  struct Found {
    std::vector<Observation> places;
    std::vector<double> shifts;
    double ncc = 0;
    int searched = 0;
  };

  Found Track(std::size_t p) const {
    Found found;
    const Vector3d &x = scene_.points[p].position, &normal = normals_[p];
    const auto slant = [&](int v) { return normal.dot((centers_[v] - x).normalized()); };
    int first = -1;
    for (const int v : scene_.points[p].views)
      if (!images_[v].grey.empty() && (first < 0 || slant(v) > slant(first))) first = v;
    if (first < 0 || slant(first) < std::cos(options_.most_slanted_deg * kDegree)) return found;
    const Vector2d center = Pixel(first, x);
    const auto patch = Cut(images_[first].grey, center, options_.radius_px);
    if (!patch) return found;
    found.places.push_back({first, static_cast<int>(p), InPhotograph(first, center)});
    for (const int v : Candidates(first, x, normal)) {
      ++found.searched;
      const Vector2d start = Pixel(v, x);
      const auto place = Fit(*patch, images_[v].grey, start, Affine(first, v, x, normal),
                             options_.most_shift_px, options_);
      if (!place) continue;
      found.places.push_back({v, static_cast<int>(p), InPhotograph(v, place->pixel)});
      found.shifts.push_back((InPhotograph(v, place->pixel) - InPhotograph(v, start)).norm());
      found.ncc += place->ncc;
    }
    return found;
  }

 private:
  Vector2d Pixel(int v, const Vector3d& x) const {
    const PatchImage& image = images_[v];
    return image.scale * scene_.views[v].Project(x) - image.origin;
  }
  Vector2d InPhotograph(int v, const Vector2d& pixel) const {
    const PatchImage& image = images_[v];
    return (pixel + image.origin) / image.scale;
  }

  /// The affine map of the plane through x from one image to another.
  Matrix2d Affine(int from, int to, const Vector3d& x, const Vector3d& normal) const {
    const Vector3d a = normal.unitOrthogonal(), b = normal.cross(a);
    const double size = 1e-3 * (centers_[from] - x).norm();
    const auto slope = [&](int v) {
      Matrix2d j;
      j << Pixel(v, x + size * a) - Pixel(v, x - size * a),
          Pixel(v, x + size * b) - Pixel(v, x - size * b);
      return j;
    };
    return slope(to) * slope(from).inverse();
  }

  /// Views that should show the patch, nearest by direction first.
  std::vector<int> Candidates(int first, const Vector3d& x, const Vector3d& normal) const {
    const Vector3d sight = (centers_[first] - x).normalized();
    std::vector<std::pair<double, int>> ranked;
    for (std::size_t v = 0; v < scene_.views.size(); ++v) {
      if (static_cast<int>(v) == first || images_[v].grey.empty()) continue;
      const Vector3d direction = (centers_[v] - x).normalized();
      if (direction.dot(sight) < std::cos(options_.widest_deg * kDegree) ||
          normal.dot(direction) < std::cos(options_.most_slanted_deg * kDegree))
        continue;
      if ((scene_.views[v].camera_from_world * x).z() <= 0) continue;
      ranked.emplace_back(-direction.dot(sight), static_cast<int>(v));
    }
    std::sort(ranked.begin(), ranked.end());
    ranked.resize(std::min(ranked.size(), static_cast<std::size_t>(options_.most_views)));
    std::vector<int> views;
    for (const auto& [closeness, v] : ranked) views.push_back(v);
    return views;
  }

  const Scene& scene_;
  const std::vector<PatchImage>& images_;
  const PatchOptions& options_;
  std::vector<Vector3d> centers_, normals_;
};

}  // namespace

PatchImage MakePatchImage(const Image8& picture, const Image8& mask, double scale,
                          const PatchOptions& options) {
  if (mask.empty()) return {Smoothed(picture, options.smoothing_px), scale, {}, Vector2d::Zero()};
  const int margin = 4 * options.radius_px;
  int x0 = picture.width, y0 = picture.height, x1 = 0, y1 = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.at(x, y) > 127) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x + 1);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y + 1);
      }
  if (x0 >= x1) return {};
  x0 = std::max(0, x0 - margin);
  y0 = std::max(0, y0 - margin);
  x1 = std::min(picture.width, x1 + margin);
  y1 = std::min(picture.height, y1 + margin);
  Image8 cut(x1 - x0, y1 - y0, 1), cut_mask = cut;
  for (int y = 0; y < cut.height; ++y) {
    std::copy_n(picture.at(x0, y0 + y), cut.width, cut.at(0, y));
    std::copy_n(mask.at(x0, y0 + y), cut.width, cut_mask.at(0, y));
  }
  return {Smoothed(cut, options.smoothing_px), scale, std::move(cut_mask), Vector2d(x0, y0)};
}

PatchTracks TrackPatches(const Scene& scene, const std::vector<PatchImage>& images,
                         const PatchOptions& options, Progress* progress) {
  if (images.size() != scene.views.size())
    throw InputError("patches: " + std::to_string(scene.views.size()) + " views, but " +
                     std::to_string(images.size()) + " photographs");
  const Tracker tracker(scene, images, options);
  std::vector<Tracker::Found> found(scene.points.size());
  ParallelFor(
      std::ssize(found),
      [&](std::int64_t p) {
        if (progress && progress->cancelled()) throw Cancelled();
        found[p] = tracker.Track(static_cast<std::size_t>(p));
      },
      16);
  PatchTracks tracks;
  tracks.scene.views = scene.views;
  std::vector<double> shifts;
  for (std::size_t p = 0; p < found.size(); ++p) {
    tracks.searched += found[p].searched;
    if (found[p].places.size() < 2) continue;
    SparsePoint point = scene.points[p];
    point.views.clear();
    for (Observation& o : found[p].places) {
      o.point = SizeOf(tracks.scene.points);
      point.views.push_back(o.view);
      tracks.observations.push_back(o);
    }
    std::sort(point.views.begin(), point.views.end());
    tracks.scene.points.push_back(std::move(point));
    tracks.source.push_back(static_cast<int>(p));
    tracks.mean_ncc += found[p].ncc;
    shifts.insert(shifts.end(), found[p].shifts.begin(), found[p].shifts.end());
  }
  if (shifts.empty()) return tracks;
  tracks.mean_ncc /= static_cast<double>(shifts.size());
  tracks.median_shift_px = UpperMedian(std::move(shifts));
  return tracks;
}

}  // namespace keypose::reconstruct
