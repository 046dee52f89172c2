#include "reconstruct/refinement/vertex_views.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

// No record of the data; the results are on the synthetic rings (docs/results/rings.md).
// Sensitivity: docs/results/sensitivity.md.
struct VertexViewTuning {
  KEYPOSE_TUNED(double, kViewFacing, 0.3);  // least cosine between normal and the view's direction
  // rad; views closer together than this have less weight
  KEYPOSE_TUNED(double, kApart, 12 * M_PI / 180);
};

constexpr int kViewGrain = 256;

// Depths of the nearest faces at the picture's pixels; infinite where there are none.
class DepthBuffer {
 public:
  DepthBuffer(const Mesh& mesh, const PreparedView& view)
      : view_(view), level_(std::min<int>(1, SizeOf(view.levels) - 1)) {
    const Pinhole& camera = view.camera(level_);
    depth_ = ImageF(camera.width, camera.height, 1, std::numeric_limits<float>::infinity());
    const Eigen::Matrix3d turn = view.camera_from_world.rotation.toRotationMatrix();
    Eigen::Matrix3Xf corners(
        3, mesh.vertex_count());  // pixel and inverse depth, which is linear in the picture
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector3d x =
          turn * mesh.points.row(v).transpose() + view.camera_from_world.translation;
      if (x.z() <= 0) {
        corners.col(v).setConstant(-1);
        continue;
      }
      const Eigen::Vector2d p = camera.Project(x);
      corners.col(v) << static_cast<float>(p.x()), static_cast<float>(p.y()),
          static_cast<float>(1 / x.z());
    }
    for (int f = 0; f < mesh.face_count(); ++f)
      Draw(corners, mesh.faces(f, 0), mesh.faces(f, 1), mesh.faces(f, 2));
  }

  // The tolerance includes the depth range of a slanted surface within a pixel.
  bool Sees(const Eigen::Vector3d& x_in_camera, double facing) const {
    const Pinhole& camera = view_.camera(level_);
    const Eigen::Vector2d p = camera.Project(x_in_camera);
    const int x = static_cast<int>(std::lround(p.x())), y = static_cast<int>(std::lround(p.y()));
    if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return false;
    const double pixel = x_in_camera.z() / camera.fx, slope = std::sqrt(1 / (facing * facing) - 1);
    return x_in_camera.z() < *depth_.at(x, y) + pixel * (1.5 + 1.5 * slope);
  }

 private:
  void Draw(const Eigen::Matrix3Xf& corners, int i, int j, int k) {
    const Eigen::Vector3f a = corners.col(i), b = corners.col(j), c = corners.col(k);
    if (a.z() <= 0 || b.z() <= 0 || c.z() <= 0) return;
    const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (std::abs(area) < 1e-12f) return;
    const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x(), b.x(), c.x()}))));
    const int x1 =
        std::min(depth_.width - 1, static_cast<int>(std::floor(std::max({a.x(), b.x(), c.x()}))));
    const int y0 = std::max(0, static_cast<int>(std::ceil(std::min({a.y(), b.y(), c.y()}))));
    const int y1 =
        std::min(depth_.height - 1, static_cast<int>(std::floor(std::max({a.y(), b.y(), c.y()}))));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const float px = static_cast<float>(x), py = static_cast<float>(y);
        const float u = ((px - a.x()) * (c.y() - a.y()) - (py - a.y()) * (c.x() - a.x())) / area;
        const float w = ((b.x() - a.x()) * (py - a.y()) - (b.y() - a.y()) * (px - a.x())) / area;
        if (u < 0 || w < 0 || u + w > 1) continue;
        float& depth = *depth_.at(x, y);
        depth = std::min(depth, 1 / (a.z() + u * (b.z() - a.z()) + w * (c.z() - a.z())));
      }
  }

  const PreparedView& view_;
  int level_;
  ImageF depth_;
};

// For each vertex: pixels per unit of length times the cosine to the viewing direction; 0 when the
// view does not see it.
std::vector<float> Sights(const Mesh& mesh, const PointsX3& normals, const PreparedView& view) {
  const DepthBuffer buffer(mesh, view);
  const Eigen::Matrix3d turn = view.camera_from_world.rotation.toRotationMatrix();
  const Pinhole& camera = view.camera();
  const GreyMask& grey = view.levels[0].grey;
  std::vector<float> sights(mesh.vertex_count(), 0.0f);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Eigen::Vector3d x =
        turn * mesh.points.row(v).transpose() + view.camera_from_world.translation;
    if (x.z() <= 0) continue;
    const double facing = -(turn * normals.row(v).transpose()).dot(x) / x.norm();
    if (facing < VertexViewTuning::kViewFacing) continue;
    const Eigen::Vector2d p = camera.Project(x);
    if (!(p.x() >= 0 && p.y() >= 0 && p.x() < camera.width - 1 && p.y() < camera.height - 1))
      continue;
    if (!InMask(*grey.at(static_cast<int>(p.x() + 0.5), static_cast<int>(p.y() + 0.5))) ||
        !buffer.Sees(x, facing))
      continue;
    sights[v] = static_cast<float>(facing * camera.fx / x.z());
  }
  return sights;
}

VertexViews Choose(const Eigen::Vector3d& x, const std::vector<std::vector<float>>& sights,
                   std::int64_t v, const std::vector<Eigen::Vector3d>& centers,
                   const std::vector<double>& focals) {
  std::vector<std::pair<int, double>> candidates;  // view and its score
  std::vector<Eigen::Vector3d> directions;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (sights[i][v] <= 0) continue;
    candidates.emplace_back(static_cast<int>(i), sights[i][v]);
    directions.push_back((centers[i] - x).normalized());
  }
  VertexViews out;
  double largest = 0;
  while (out.count < kBestViews) {
    int best = -1;
    for (std::size_t c = 0; c < candidates.size(); ++c)
      if (candidates[c].second > 0 && (best < 0 || candidates[c].second > candidates[best].second))
        best = static_cast<int>(c);
    if (best < 0) break;
    const int view = candidates[best].first;
    out.view[out.count++] = static_cast<std::int16_t>(view);
    largest = std::max(largest, focals[view] / (centers[view] - x).norm());
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const double angle = std::acos(std::clamp(directions[best].dot(directions[c]), -1.0, 1.0));
      candidates[c].second *= std::min(1.0, angle / VertexViewTuning::kApart);
    }
    candidates[best].second = 0;
  }
  if (out.count) out.footprint = static_cast<float>(1 / largest);
  return out;
}

}  // namespace

std::vector<std::vector<float>> AllSights(const Mesh& mesh, const PointsX3& normals,
                                          const std::vector<PreparedView>& views) {
  std::vector<std::vector<float>> sights(views.size());
  ParallelFor(std::ssize(views),
              [&](std::int64_t i) { sights[i] = Sights(mesh, normals, views[i]); });
  return sights;
}

std::vector<VertexViews> ChooseViews(const PointsX3& points, const std::vector<PreparedView>& views,
                                     const std::vector<std::vector<float>>& sights) {
  std::vector<Eigen::Vector3d> centers;
  std::vector<double> focals;
  for (const PreparedView& view : views) {
    centers.push_back(view.Center());
    focals.push_back(view.camera().fx);
  }
  std::vector<VertexViews> out(points.rows());
  ParallelFor(
      points.rows(),
      [&](std::int64_t v) { out[v] = Choose(points.row(v), sights, v, centers, focals); },
      kViewGrain);
  return out;
}

}  // namespace keypose::reconstruct
