#include "composite/locating/candidates/feature_search.h"

#include <algorithm>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
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

struct Box {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Around the matte, with room for features at its border.
Box BoxOf(const Image8& matte, const Image8& picture) {
  if (matte.empty()) return {0, 0, picture.width, picture.height};
  constexpr int kRoom = 24;
  Box box{matte.width, matte.height, 0, 0};
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x)
      if (matte.at(x, y)[0] > 127)
        box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1),
               std::max(box.y1, y + 1)};
  if (box.x0 >= box.x1) return {};
  return {std::max(0, box.x0 - kRoom), std::max(0, box.y0 - kRoom),
          std::min(matte.width, box.x1 + kRoom), std::min(matte.height, box.y1 + kRoom)};
}

Image8 Cropped(const Image8& image, const Box& box) {
  if (image.empty()) return {};
  Image8 part(box.x1 - box.x0, box.y1 - box.y0, image.channels);
  for (int y = 0; y < part.height; ++y)
    std::copy_n(image.at(box.x0, box.y0 + y), part.width * part.channels, part.at(0, y));
  return part;
}

/// Features of the part of the picture that the matte covers, with pixels of the whole picture.
PictureFeatures FeaturesWithin(const Image8& picture, const Image8& matte) {
  const Box box = BoxOf(matte, picture);
  if (box.x0 >= box.x1) return {};
  PictureFeatures found = FindFeatures(Cropped(picture, box), Cropped(matte, box), kMostFeatures);
  for (Eigen::Vector2d& pixel : found.pixels) pixel += Eigen::Vector2d(box.x0, box.y0);
  return found;
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
  const std::vector<FeatureMatch> matches = features.Match(FeaturesWithin(picture, matte));
  const double within = FeatureSearchTuning::kWithin * std::max(camera.width, camera.height);
  std::optional<FeatureCandidate> best;
  for (const double factor : focal_factors) {
    const PicturePose pose = PlacePicture(PinholeOf(camera, factor), points, matches, within,
                                          FeatureSearchTuning::kLeastInliers);
    if (!pose.found || (best && pose.inliers.size() <= best->inliers.size())) continue;
    FeatureCandidate candidate;
    candidate.placement = {camera, pose.camera_from_world};
    candidate.placement.camera.fx *= factor;
    candidate.placement.camera.fy *= factor;
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
