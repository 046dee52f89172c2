#include "fit/cameras/find_cameras.h"

#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "views/placement/picture_pose.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct FindCamerasTuning {
  KEYPOSE_TUNED(double, kWithin,
                0.008);  // largest error of an inlier, of the picture's longer side
  // Least share of the matches that agree. Clay creatures reach 0.58; a wrong camera of a skull
  // that bent by 40 degrees had 0.10.
  KEYPOSE_TUNED(double, kLeastShare, 0.12);
  // Likewise, of a camera that is sure: a skull's wrong one had 0.20, its right ones 0.37 and more.
  KEYPOSE_TUNED(double, kSureShare, 0.3);
};

constexpr int kMostFeatures = 2500, kLeastInliers = 12;

}  // namespace

std::vector<FeatureMatch> CountedPicks(const FoundCamera& camera) {
  // A pick is worth so many features: four on what did not move are enough.
  constexpr int kFeaturesAPick = 4;
  std::vector<FeatureMatch> counted;
  for (int k = 0; k < kFeaturesAPick; ++k)
    counted.insert(counted.end(), camera.picks.begin(), camera.picks.end());
  return counted;
}

std::vector<FeatureMatch> AllMatches(const FoundCamera& camera) {
  std::vector<FeatureMatch> all = camera.matches;
  const std::vector<FeatureMatch> picks = CountedPicks(camera);
  all.insert(all.end(), picks.begin(), picks.end());
  return all;
}

std::vector<FoundCamera> FindCameras(const Mesh& mesh, const SurfaceFeatures* features,
                                     const std::vector<PreparedView>& views,
                                     const std::vector<std::vector<FeatureMatch>>& picks,
                                     Progress* progress) {
  std::vector<PictureFeatures> pictures(views.size());
  ReportProgress(progress, 0, "features of the photographs");
  ParallelFor(features ? SizeOf(views) : 0, [&](std::int64_t v) {
    pictures[v] = FindFeatures(views[v].color, MaskOf(views[v]), kMostFeatures);
  });
  std::vector<FoundCamera> cameras(views.size());
  for (int v = 0; v < SizeOf(views); ++v) {
    ReportProgress(progress, 0.3 + 0.7 * v / SizeOf(views), "cameras of the photographs");
    FoundCamera& camera = cameras[v];
    if (features) camera.matches = features->Match(pictures[v]);
    camera.picks = picks[v];
    const Pinhole& pinhole = views[v].camera();
    const double within = FindCamerasTuning::kWithin * std::max(pinhole.width, pinhole.height);
    const PicturePose pose =
        PlacePicture(pinhole, mesh.points, AllMatches(camera), within, kLeastInliers);
    camera.camera_from_world = pose.camera_from_world;
    camera.inliers = SizeOf(pose.inliers);
    for (const int i : pose.inliers)
      if (i < SizeOf(camera.matches)) camera.agreeing.push_back(camera.matches[i]);
    const int by_picks = camera.inliers - SizeOf(camera.agreeing);
    camera.found = pose.found && (by_picks >= kLeastInliers ||
                                  SizeOf(camera.agreeing) >=
                                      FindCamerasTuning::kLeastShare * SizeOf(camera.matches));
    camera.rms_px = pose.rms_px;
  }
  return cameras;
}

bool KeepSureCameras(std::vector<FoundCamera>& cameras) {
  constexpr int kEnough = 3;
  const auto sure = [](const FoundCamera& camera) {
    return camera.found && camera.inliers >= FindCamerasTuning::kSureShare * SizeOf(camera.matches);
  };
  if (std::count_if(cameras.begin(), cameras.end(), sure) < kEnough) return false;
  bool dropped = false;
  for (FoundCamera& camera : cameras) {
    dropped = dropped || (camera.found && !sure(camera));
    camera.found = sure(camera);
  }
  return dropped;
}

}  // namespace keypose::fit
