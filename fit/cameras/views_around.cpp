#include "fit/cameras/views_around.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/numbers/parallel.h"
#include "core/pictures/fit_view.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

constexpr int kSize = 96;  // px: longer side of the small pictures
constexpr int kAzimuths = 24;
constexpr double kElevations[] = {-15, 5, 25, 45, 65};  // degrees

/// A photograph in small.
struct Small {
  Camera camera;
  std::vector<char> mask;
  PointsX3 colors;  // pixels x 3
};

/// The mean colour of what is inside the mask, and which share of the block that is.
double BlockOf(const PreparedView& view, int x0, int y0, int x1, int y1, Eigen::RowVector3d& mean) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  int inside = 0;
  for (int v = y0; v < y1; ++v)
    for (int u = x0; u < x1; ++u) {
      if (!InMask(*view.levels[0].grey.at(u, v))) continue;
      const std::uint8_t* p = view.color.at(u, v);
      sum += Eigen::RowVector3d(p[0], p[1], p[2]);
      ++inside;
    }
  if (inside > 0) mean = sum / inside;
  return static_cast<double>(inside) / std::max(1, (x1 - x0) * (y1 - y0));
}

Small SmallOf(const PreparedView& view) {
  const Pinhole& full = view.camera();
  const double factor = static_cast<double>(kSize) / std::max(full.width, full.height);
  Small small;
  Camera& c = small.camera;
  c.width = std::max(1, static_cast<int>(full.width * factor));
  c.height = std::max(1, static_cast<int>(full.height * factor));
  c.fx = full.fx * factor;
  c.fy = full.fy * factor;
  c.cx = (full.cx + 0.5) * factor;
  c.cy = (full.cy + 0.5) * factor;
  small.mask.resize(static_cast<std::size_t>(c.width) * c.height);
  small.colors.resize(SizeOf(small.mask), 3);
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const int x0 = static_cast<int>(x / factor), y0 = static_cast<int>(y / factor);
      const int x1 = std::min(full.width, static_cast<int>((x + 1) / factor));
      const int y1 = std::min(full.height, static_cast<int>((y + 1) / factor));
      Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
      const int at = y * c.width + x;
      small.mask[at] = BlockOf(view, x0, y0, x1, y1, mean) > 0.5;
      small.colors.row(at) = mean;
    }
  return small;
}

struct Spread {
  double area = 0;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
};

template <typename Inside>
Spread SpreadOf(int width, int height, const Inside& inside) {
  Spread spread;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (inside(y * width + x)) {
        spread.area += 1;
        spread.center += Eigen::Vector2d(x + 0.5, y + 0.5);
      }
  if (spread.area > 0) spread.center /= spread.area;
  return spread;
}

/// The camera on the side `away` of `target`, which it shows at `pixel`.
Rigid3 Placed(const Camera& camera, const Eigen::Vector3d& away, const Eigen::Vector3d& target,
              double distance, const Eigen::Vector2d& pixel) {
  const Rigid3 straight = LookAt(target + distance * away, target);
  const Eigen::Vector3d ray = camera.Unproject(pixel).normalized();
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray);
  const Eigen::Quaterniond rotation = (turn * straight.rotation).normalized();
  return {rotation, distance * ray - rotation * target};
}

class Sides {
 public:
  Sides(const Mesh& mesh, const Image8& texture, const RayScene& scene, const Small& small)
      : mesh_(mesh), texture_(texture), scene_(scene), small_(small) {
    mask_ = SpreadOf(small.camera.width, small.camera.height, [&](int i) { return small.mask[i]; });
    center_ = (mesh.points.colwise().minCoeff() + mesh.points.colwise().maxCoeff()).transpose() / 2;
  }

  ViewAround From(double azimuth, double elevation) const {
    const Eigen::Vector3d away(std::cos(elevation) * std::cos(azimuth),
                               std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const Camera& camera = small_.camera;
    View view{"", camera, {}};
    Eigen::Vector2d pixel = mask_.center;
    double distance = camera.fx * BoundingDiagonal(mesh_.points) / std::sqrt(2 * mask_.area + 1);
    Raster raster;
    constexpr int kRounds = 3;
    for (int round = 0;; ++round) {
      view.camera_from_world = Placed(camera, away, center_, distance, pixel);
      raster = Rasterize(mesh_, scene_, view);
      if (round == kRounds) break;
      const Spread shown =
          SpreadOf(camera.width, camera.height, [&](int i) { return raster.face.data[i] >= 0; });
      if (shown.area == 0) break;
      distance *= std::sqrt(shown.area / mask_.area);
      pixel += mask_.center - shown.center;
    }
    return Judged(view, raster);
  }

  bool visible() const { return mask_.area > 0; }

 private:
  ViewAround Judged(const View& view, const Raster& raster) const {
    ViewAround judged{view.camera_from_world, 0, 0};
    std::vector<int> both;
    int either = 0;
    for (int i = 0; i < SizeOf(small_.mask); ++i) {
      const bool shown = raster.face.data[i] >= 0;
      if (shown && small_.mask[i]) both.push_back(i);
      either += shown || small_.mask[i];
    }
    if (both.empty()) return judged;
    judged.overlap = static_cast<double>(SizeOf(both)) / either;
    if (!texture_.empty()) judged.likeness = Likeness(view, both);
    return judged;
  }

  /// Whatever the brightness of each channel.
  double Likeness(const View& view, const std::vector<int>& pixels) const {
    RenderOptions options;
    options.texture = &texture_;
    options.shading = 0;
    options.samples = 2;
    const Image8 picture = Render(mesh_, scene_, view, options);
    PointsX3 ours(SizeOf(pixels), 3), theirs(SizeOf(pixels), 3);
    for (int k = 0; k < SizeOf(pixels); ++k) {
      for (int c = 0; c < 3; ++c)
        ours(k, c) = picture.data[3 * static_cast<std::size_t>(pixels[k]) + c];
      theirs.row(k) = small_.colors.row(pixels[k]);
    }
    ours.rowwise() -= ours.colwise().mean().eval();
    theirs.rowwise() -= theirs.colwise().mean().eval();
    const double norm = ours.norm() * theirs.norm();
    return norm > 0 ? (ours.array() * theirs.array()).sum() / norm : 0;
  }

  const Mesh& mesh_;
  const Image8& texture_;
  const RayScene& scene_;
  const Small& small_;
  Spread mask_;
  Eigen::Vector3d center_;
};

}  // namespace

std::vector<ViewAround> ViewsAround(const Mesh& mesh, const Image8& texture, const RayScene& scene,
                                    const PreparedView& photograph, int most) {
  const Small small = SmallOf(photograph);
  const Sides sides(mesh, texture, scene, small);
  if (!sides.visible()) return {};
  constexpr int kRings = static_cast<int>(std::size(kElevations));
  std::vector<ViewAround> views(kAzimuths * kRings);
  constexpr double kDegree = std::numbers::pi / 180;
  ParallelFor(SizeOf(views), [&](std::int64_t i) {
    views[i] = sides.From(360.0 / kAzimuths * static_cast<double>(i % kAzimuths) * kDegree,
                          kElevations[i / kAzimuths] * kDegree);
  });
  std::stable_sort(views.begin(), views.end(), [](const auto& a, const auto& b) {
    return a.overlap * (1 + a.likeness) > b.overlap * (1 + b.likeness);
  });
  views.resize(std::min<std::size_t>(views.size(), most));
  return views;
}

}  // namespace keypose::fit
