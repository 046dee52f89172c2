#include "fit/following/cross_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::fit {
namespace {

// First guesses; not tuned.
struct CrossViewTuning {
  // Distance from the line on which a match must lie at which it has a quarter of its weight [px].
  KEYPOSE_TUNED(double, kBesideLine, 1);
  KEYPOSE_TUNED(double, kShiftScale, 6);     // shift at which it has a quarter of its weight [px]
  KEYPOSE_TUNED(double, kLeastFacing, 0.3);  // cosine towards the other view
};

constexpr double kHidden = 3;  // this far behind what a view sees, a point is hidden [footprints]

/// Brightness at a point in a view, if it is seen there.
bool Seen(const ShownView& view, const Eigen::Vector3d& x_in_world, float* grey) {
  const Eigen::Vector3d x = view.at.camera_from_world * x_in_world;
  if (x.z() <= 0) return false;
  const Eigen::Vector2d pixel = view.at.camera.Project(x);
  const int px = static_cast<int>(std::lround(pixel.x())),
            py = static_cast<int>(std::lround(pixel.y()));
  if (px < 1 || py < 1 || px >= view.at.camera.width - 1 || py >= view.at.camera.height - 1)
    return false;
  if (*view.shape.face.at(px, py) < 0 || !InMask(*view.mask->at(px, py))) return false;
  // Within the depths around, since a slanted surface has others a pixel away.
  float farthest = 0;
  for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}})
    if (const float z = *view.shape.depth.at(px + dx, py + dy); std::isfinite(z))
      farthest = std::max(farthest, z);
  if (x.z() > farthest + kHidden * x.z() / view.at.camera.fx) return false;
  *grey = SampleGrey(*view.grey, pixel.x(), pixel.y());
  return true;
}

}  // namespace

std::vector<std::pair<int, int>> NeighbouringViews(const std::vector<ShownView>& views,
                                                   const Eigen::Vector3d& middle) {
  constexpr int kNeighbours = 2;
  const double most = std::cos(5 * kDegree), least = std::cos(80 * kDegree);
  std::set<std::pair<int, int>> pairs;
  for (int v = 0; v < SizeOf(views); ++v) {
    std::vector<std::pair<double, int>> others;
    const Eigen::Vector3d to = (views[v].at.Center() - middle).normalized();
    for (int o = 0; o < SizeOf(views); ++o) {
      const double cosine = to.dot((views[o].at.Center() - middle).normalized());
      if (o != v && cosine < most && cosine > least) others.emplace_back(-cosine, o);
    }
    std::sort(others.begin(), others.end());
    for (int i = 0; i < std::min(kNeighbours, SizeOf(others)); ++i)
      pairs.insert(std::minmax(v, others[i].second));
  }
  return {pairs.begin(), pairs.end()};
}

TexturedRender ShownBy(const ShownView& other, const ShownView& view) {
  TexturedRender shown = view.shape;
  const Eigen::Matrix3d turn = view.at.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d eye = view.at.Center();
  for (int y = 0; y < shown.face.height; ++y)
    for (int x = 0; x < shown.face.width; ++x) {
      float& depth = *shown.depth.at(x, y);
      if (*shown.face.at(x, y) < 0) continue;
      const Eigen::Vector3d point =
          eye + turn * view.at.camera.Ray(x, y) * static_cast<double>(depth);
      if (!Seen(other, point, shown.grey.at(x, y))) depth = std::numeric_limits<float>::infinity();
    }
  return shown;
}

std::vector<Constraint> CrossViewConstraints(const PointsX3& points, const PointsX3& normals,
                                             const ShownView& view, const ShownView& other,
                                             const Eigen::VectorXd& areas, double weight) {
  using Tuning = CrossViewTuning;
  const TexturedRender shown = ShownBy(other, view);
  const Eigen::Vector3d eye = other.at.Center();
  std::vector<SeenVertex> seen;
  for (const SeenVertex& vertex : view.seen) {
    const Eigen::Vector3d x = points.row(vertex.vertex);
    if (normals.row(vertex.vertex).dot((eye - x).normalized()) > Tuning::kLeastFacing)
      seen.push_back(vertex);
  }
  const std::vector<PatchShift> shifts =
      FindShifts(seen, shown, *view.grey, *view.mask, view.at.camera.fx, view.noise, {});
  std::vector<Constraint> constraints;
  for (int i = 0; i < SizeOf(seen); ++i) {
    const PatchShift& patch = shifts[i];
    if (!patch.found) continue;
    const int v = seen[i].vertex;
    const Eigen::Vector3d x = points.row(v), normal = normals.row(v), ray = (x - eye).normalized();
    double footprint = 0;
    const Eigen::Vector2d line = ScaledJacobian(view.at, x, &footprint) * ray;
    const double sure = line.dot(patch.confidence * line);
    if (sure < 1e-6) continue;
    const double along_px = line.dot(patch.confidence * patch.shift) / sure;
    const double beside_px = (patch.shift - along_px * line).norm();
    const double w = weight * areas[v] * patch.correlation * patch.correlation * seen[i].facing *
                     sure * RobustWeight(beside_px, Tuning::kBesideLine) *
                     RobustWeight(patch.shift.norm(), Tuning::kShiftScale);
    constraints.push_back({view.at.index, v, Eigen::Vector3d::Zero(),
                           w * normal * normal.transpose(), x + along_px * footprint * ray});
  }
  return constraints;
}

}  // namespace keypose::fit
