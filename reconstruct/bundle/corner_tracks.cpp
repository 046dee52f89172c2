#include "reconstruct/bundle/corner_tracks.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct CornerTuning {
  /// cosine between directions: views that are nearer to each other see the same corner
  KEYPOSE_TUNED(double, kSeesToo, 0.8);
};

/// Sums over squares of side 2 radius + 1, in place; a margin of `radius` is not changed.
void SumSquares(ImageF& image, int radius) {
  ImageF across(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y) {
    double sum = 0;
    for (int x = 0; x < image.width; ++x) {
      sum += *image.at(x, y);
      if (x > 2 * radius) sum -= *image.at(x - 2 * radius - 1, y);
      if (x >= 2 * radius) *across.at(x - radius, y) = static_cast<float>(sum);
    }
  }
  std::vector<double> sums(static_cast<std::size_t>(image.width), 0.0);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double& sum = sums[x];
      sum += *across.at(x, y);
      if (y > 2 * radius) sum -= *across.at(x, y - 2 * radius - 1);
      if (y >= 2 * radius) *image.at(x, y - radius) = static_cast<float>(sum);
    }
}

/// Smaller eigenvalue of the structure tensor over a patch.
ImageF Cornerness(const ImageF& grey, int radius) {
  ImageF xx(grey.width, grey.height, 1), xy = xx, yy = xx;
  for (int y = 1; y + 1 < grey.height; ++y)
    for (int x = 1; x + 1 < grey.width; ++x) {
      const float gx = 0.5F * (*grey.at(x + 1, y) - *grey.at(x - 1, y)),
                  gy = 0.5F * (*grey.at(x, y + 1) - *grey.at(x, y - 1));
      *xx.at(x, y) = gx * gx;
      *xy.at(x, y) = gx * gy;
      *yy.at(x, y) = gy * gy;
    }
  for (ImageF* moment : {&xx, &xy, &yy}) SumSquares(*moment, radius);
  for (std::size_t k = 0; k < xx.data.size(); ++k) {
    const float half = 0.5F * (xx.data[k] + yy.data[k]),
                difference = 0.5F * (xx.data[k] - yy.data[k]);
    xx.data[k] = half - std::sqrt(difference * difference + xy.data[k] * xy.data[k]);
  }
  return xx;
}

bool WellInside(const Image8& mask, int x, int y, int reach) {
  if (x < reach || y < reach || x + reach >= mask.width || y + reach >= mask.height) return false;
  for (const int dy : {-reach, 0, reach})
    for (const int dx : {-reach, 0, reach})
      if (*mask.at(x + dx, y + dy) <= 127) return false;
  return true;
}

struct Corner {
  Vector2d pixel;  ///< of the patch image
  float strength = 0;
};

/// The strongest of each cell, strongest first.
std::vector<Corner> CornersOf(const PatchImage& image, int radius, int cell) {
  std::vector<Corner> corners;
  if (image.mask.empty()) return corners;
  const ImageF strength = Cornerness(image.grey, radius);
  const int margin = radius + 3;
  for (int y0 = margin; y0 + cell <= image.grey.height - margin; y0 += cell)
    for (int x0 = margin; x0 + cell <= image.grey.width - margin; x0 += cell) {
      Corner best;
      for (int y = y0; y < y0 + cell; ++y)
        for (int x = x0; x < x0 + cell; ++x)
          if (*strength.at(x, y) > best.strength && WellInside(image.mask, x, y, radius))
            best = {Vector2d(x + 0.5, y + 0.5), *strength.at(x, y)};
      if (best.strength > 0) corners.push_back(best);
    }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.strength > b.strength; });
  return corners;
}

/// Projections of known points in one view, by cells.
class ProjectedPoints {
 public:
  struct Spot {
    Vector2d pixel;
    double inverse_depth = 0;
  };
  ProjectedPoints(int width, int height, int cell)
      : cell_(cell), columns_(width / cell + 1), rows_(height / cell + 1) {
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  }
  void Add(const Spot& spot) {
    if (const auto at = At(spot.pixel)) cells_[*at].push_back(spot);
  }
  bool Near(const Vector2d& pixel, double distance) const {
    bool near = false;
    Around(pixel, 1, [&](const Spot& spot) { near |= (spot.pixel - pixel).norm() < distance; });
    return near;
  }
  std::vector<Spot> Nearest(const Vector2d& pixel, int count, double reach) const {
    std::vector<std::pair<double, Spot>> found;
    Around(pixel, static_cast<int>(std::ceil(reach / cell_)), [&](const Spot& spot) {
      if (const double d = (spot.pixel - pixel).norm(); d < reach) found.emplace_back(d, spot);
    });
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Spot> nearest;
    for (std::size_t k = 0;
         k < std::min<std::size_t>(found.size(), static_cast<std::size_t>(count)); ++k)
      nearest.push_back(found[k].second);
    return nearest;
  }

 private:
  std::optional<std::size_t> At(const Vector2d& pixel) const {
    const double x = std::floor(pixel.x() / cell_), y = std::floor(pixel.y() / cell_);
    if (!(x >= 0 && y >= 0 && x < columns_ && y < rows_)) return std::nullopt;
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x);
  }
  template <class Visit>
  void Around(const Vector2d& pixel, int reach, const Visit& visit) const {
    const int x = static_cast<int>(pixel.x()) / cell_, y = static_cast<int>(pixel.y()) / cell_;
    for (int j = std::max(0, y - reach); j <= std::min(rows_ - 1, y + reach); ++j)
      for (int i = std::max(0, x - reach); i <= std::min(columns_ - 1, x + reach); ++i)
        for (const Spot& spot :
             cells_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(i)])
          visit(spot);
  }

  int cell_, columns_, rows_;
  std::vector<std::vector<Spot>> cells_;
};

/// Inverse depth at a pixel from the plane through points around it: a plane's inverse depth is
/// linear over the picture.
std::optional<double> InverseDepthAt(const Vector2d& pixel,
                                     const std::vector<ProjectedPoints::Spot>& spots,
                                     double most_bent) {
  if (spots.size() < 4) return std::nullopt;
  Eigen::Matrix3d a =
      1e-3 * Eigen::Vector3d(0, 1, 1).asDiagonal().toDenseMatrix();  // level if collinear
  Vector3d b = Vector3d::Zero();
  for (const ProjectedPoints::Spot& spot : spots) {
    const Vector3d row(1, spot.pixel.x() - pixel.x(), spot.pixel.y() - pixel.y());
    a += row * row.transpose();
    b += row * spot.inverse_depth;
  }
  const Vector3d plane = a.ldlt().solve(b);
  if (!plane.allFinite() || plane(0) <= 0) return std::nullopt;
  double squares = 0;
  for (const ProjectedPoints::Spot& spot : spots) {
    const double off =
        plane.dot(Vector3d(1, spot.pixel.x() - pixel.x(), spot.pixel.y() - pixel.y())) -
        spot.inverse_depth;
    squares += off * off / static_cast<double>(spots.size());
  }
  if (std::sqrt(squares) > most_bent * plane(0)) return std::nullopt;
  return plane(0);
}

/// A point that view v sees at a pixel of its patch image.
SparsePoint PointAt(const Vector2d& pixel, double inverse_depth, const PatchImage& image,
                    const View& view, std::size_t v) {
  const Vector3d ray = view.camera.Unproject((pixel + image.origin) / image.scale);
  SparsePoint point;
  point.position = view.camera_from_world.Inverse() * Vector3d(ray / inverse_depth);
  point.color.setConstant(160);
  point.views = {static_cast<int>(v)};
  return point;
}

}  // namespace

Scene AddCorners(const Scene& scene, const std::vector<PatchImage>& images,
                 const PatchOptions& patches, const CornerOptions& options) {
  Scene more = scene;
  std::vector<std::vector<Corner>> corners(scene.views.size());
  ParallelFor(std::ssize(corners), [&](std::int64_t v) {
    corners[v] = CornersOf(images[v], patches.radius_px, options.cell_px);
  });
  std::vector<ProjectedPoints> shown;
  const auto show = [&](const Vector3d& x, std::size_t v) {
    const PatchImage& image = images[v];
    const double depth = (scene.views[v].camera_from_world * x).z();
    if (depth > 0)
      shown[v].Add({image.scale * scene.views[v].Project(x) - image.origin, 1 / depth});
  };
  for (const PatchImage& image : images)
    shown.emplace_back(image.grey.width, image.grey.height, options.cell_px);
  for (const SparsePoint& point : scene.points)
    for (const int v : point.views) show(point.position, static_cast<std::size_t>(v));
  const std::vector<ProjectedPoints> known = shown;  // depths are interpolated from these alone
  // One corner of each view in turn, so that points are distributed evenly over the views.
  std::vector<std::size_t> next(corners.size(), 0);
  for (bool any = true; any && SizeOf(more.points) < options.most_points;) {
    any = false;
    for (std::size_t v = 0; v < corners.size(); ++v)
      while (next[v] < corners[v].size()) {
        const Corner& corner = corners[v][next[v]++];
        any = true;
        if (shown[v].Near(corner.pixel, options.cell_px)) continue;
        const auto inverse_depth = InverseDepthAt(
            corner.pixel, known[v].Nearest(corner.pixel, options.neighbors, options.reach_px),
            options.most_bent);
        if (!inverse_depth) continue;
        const View& view = scene.views[v];
        SparsePoint point = PointAt(corner.pixel, *inverse_depth, images[v], view, v);
        // Views with similar directions see the same corner, which is added only once.
        for (std::size_t w = 0; w < scene.views.size(); ++w)
          if ((scene.views[w].Center() - point.position)
                  .normalized()
                  .dot((view.Center() - point.position).normalized()) > CornerTuning::kSeesToo)
            show(point.position, w);
        more.points.push_back(std::move(point));
        break;
      }
  }
  return more;
}

}  // namespace keypose::reconstruct
