#include "composite/locating/candidates/feature_search.h"

#include <algorithm>
#include <cmath>

#include "core/geometry.h"
#include "core/size_of.h"
#include "core/tuned.h"
#include "views/placement/picture_pose.h"

namespace keypose::composite {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct FeatureSearchTuning {
  KEYPOSE_TUNED(double, kWithin, 0.004);  // largest error of an inlier, of the longer side
  KEYPOSE_TUNED(int, kLeastInliers, 14);
  KEYPOSE_TUNED(double, kLeastSpread, 0.08);  // of the inliers on the mesh [diagonal]
};
constexpr int kMostFeatures = 3000;

Pinhole PinholeOf(const Camera& camera, double focal_factor) {
  return {camera.width,    camera.height,  camera.fx * focal_factor, camera.fy * focal_factor,
          camera.cx - 0.5, camera.cy - 0.5};
}

/// Root mean square distance of the inliers from their mean: features of one spot say nothing of
/// the rest.
double SpreadOf(const std::vector<Sighting>& sightings, const PointsX3& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Sighting& s : sightings) mean += PositionOf(s.point, points) / SizeOf(sightings);
  double sum = 0;
  for (const Sighting& s : sightings) sum += (PositionOf(s.point, points) - mean).squaredNorm();
  return std::sqrt(sum / SizeOf(sightings));
}

}  // namespace

Placement RefinedBySightings(const Placement& start, const PointsX3& points,
                             const std::vector<Sighting>& sightings, double within_px,
                             const Eigen::Vector3d& center, double radius, bool focal, int rounds) {
  Placement at = start;
  const double s2 = within_px * within_px;
  for (int round = 0; round < rounds; ++round) {
    NormalEquations equations(at, center, radius);
    for (const Sighting& sighting : sightings) {
      const Eigen::Vector3d x = PositionOf(sighting.point, points);
      const Eigen::Vector2d error = sighting.pixel - at.Project(x);
      const double robust = s2 / (s2 + error.squaredNorm());
      equations.Add(x, Eigen::Vector2d::UnitX(), error.x(), robust * robust);
      equations.Add(x, Eigen::Vector2d::UnitY(), error.y(), robust * robust);
    }
    const Step step = equations.Solve(FreeUnknowns(focal, false), 1e-6);
    at = equations.Moved(step);
    if (step.norm() < 1e-10) break;
  }
  return at;
}

std::optional<FeatureCandidate> PlaceByFeatures(const SurfaceFeatures& features,
                                                const PointsX3& points, const Image8& picture,
                                                const Image8& matte, const Camera& camera,
                                                const std::vector<double>& focal_factors) {
  const std::vector<FeatureMatch> matches =
      features.Match(FindFeatures(picture, matte, kMostFeatures));
  const double within = FeatureSearchTuning::kWithin * std::max(camera.width, camera.height);
  std::optional<FeatureCandidate> best;
  for (const double factor : focal_factors) {
    const PicturePose pose = PlacePicture(PinholeOf(camera, factor), points, matches, within,
                                          FeatureSearchTuning::kLeastInliers);
    if (!pose.found || (best && pose.inliers.size() <= best->inliers.size())) continue;
    FeatureCandidate candidate;
    candidate.placement = {camera, pose.camera_from_world};
    candidate.placement.camera.fx *= factor, candidate.placement.camera.fy *= factor;
    candidate.rms_px = pose.rms_px;
    for (const int i : pose.inliers)
      candidate.inliers.push_back(
          {matches[i].point, matches[i].pixel + Eigen::Vector2d::Constant(0.5)});
    if (SpreadOf(candidate.inliers, points) <
        FeatureSearchTuning::kLeastSpread * BoundingDiagonal(points))
      continue;
    best = candidate;
  }
  return best;
}

}  // namespace keypose::composite
