#include "fit/cameras/find_cameras.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/size_of.h"
#include "core/tuned.h"
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
  KEYPOSE_TUNED(double, kRigWithin, 0.012);    // likewise, under a camera of the rig
  KEYPOSE_TUNED(double, kAsGood, 0.85);        // share of the most inliers that is as good
  KEYPOSE_TUNED(double, kLeastAgreeing, 0.6);  // share of the photographs
  // Inliers under the rig's cameras, over those under cameras found one by one.
  KEYPOSE_TUNED(double, kLeastInCommon, 0.7);
};

constexpr int kMostFeatures = 2500, kLeastInliers = 12;
// A pick is worth so many features: four on what did not move are enough.
constexpr int kFeaturesAPick = 4;

/// Features and picks of a photograph, the picks as often as they count.
std::vector<FeatureMatch> AllMatches(const FoundCamera& camera) {
  std::vector<FeatureMatch> all = camera.matches;
  for (int k = 0; k < kFeaturesAPick; ++k)
    all.insert(all.end(), camera.picks.begin(), camera.picks.end());
  return all;
}

}  // namespace

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

namespace {

/// The matches of one photograph, ready for counting.
struct Sightings {
  Pinhole camera;
  PointsX3 places;  // on the template
  std::vector<Eigen::Vector2d> pixels;
  double within = 0;

  int Inliers(const Rigid3& camera_from_template, std::vector<int>* indices = nullptr) const {
    int count = 0;
    const Eigen::Matrix3d turn = camera_from_template.rotation.toRotationMatrix();
    for (int i = 0; i < SizeOf(pixels); ++i) {
      const Eigen::Vector3d x = turn * places.row(i).transpose() + camera_from_template.translation;
      if (x.z() <= 0 || (camera.Project(x) - pixels[i]).squaredNorm() > within * within) continue;
      ++count;
      if (indices) indices->push_back(i);
    }
    return count;
  }
};

std::vector<Sightings> SightingsOf(const Mesh& mesh, const std::vector<FoundCamera>& cameras,
                                   const std::vector<PreparedView>& views) {
  std::vector<Sightings> sightings(views.size());
  for (int v = 0; v < SizeOf(views); ++v) {
    Sightings& s = sightings[v];
    s.camera = views[v].camera();
    s.within = FindCamerasTuning::kRigWithin * std::max(s.camera.width, s.camera.height);
    const std::vector<FeatureMatch> matches = AllMatches(cameras[v]);
    s.places.resize(SizeOf(matches), 3);
    for (int i = 0; i < SizeOf(matches); ++i) {
      s.places.row(i) = PositionOf(matches[i].point, mesh.points);
      s.pixels.push_back(matches[i].pixel);
    }
  }
  return sightings;
}

/// The best rig camera of each photograph under one motion. @return inliers of all photographs
int Assign(const std::vector<Sightings>& sightings, const std::vector<View>& rig, RigMatch& match) {
  match.rig_view.assign(sightings.size(), -1);
  match.inliers.assign(sightings.size(), 0);
  int sum = 0;
  match.agreeing = 0;
  for (int i = 0; i < SizeOf(sightings); ++i) {
    for (int j = 0; j < SizeOf(rig); ++j) {
      const int inliers =
          sightings[i].Inliers(Compose(rig[j].camera_from_world, match.rig_from_template));
      if (inliers > match.inliers[i]) match.inliers[i] = inliers, match.rig_view[i] = j;
    }
    if (match.inliers[i] < kLeastInliers) match.rig_view[i] = -1;
    match.agreeing += match.rig_view[i] >= 0;
    sum += match.inliers[i];
  }
  return sum;
}

/// Improves the figure's motion on the inliers of all photographs.
Rigid3 RefinedMotion(const std::vector<Sightings>& sightings, const std::vector<View>& rig,
                     const RigMatch& match) {
  Rigid3 motion = match.rig_from_template;
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (int i = 0; i < SizeOf(sightings); ++i) {
      if (match.rig_view[i] < 0) continue;
      const Sightings& s = sightings[i];
      const Rigid3& camera = rig[match.rig_view[i]].camera_from_world;
      std::vector<int> inliers;
      s.Inliers(Compose(camera, motion), &inliers);
      const Eigen::Matrix3d turn = camera.rotation.toRotationMatrix();
      for (const int k : inliers) {
        const Eigen::Vector3d y = motion * s.places.row(k).transpose(), x = camera * y;
        Eigen::Matrix<double, 2, 3> d;
        d << s.camera.fx / x.z(), 0, -s.camera.fx * x.x() / (x.z() * x.z()), 0, s.camera.fy / x.z(),
            -s.camera.fy * x.y() / (x.z() * x.z());
        Eigen::Matrix<double, 3, 6> move;
        move << 0, y.z(), -y.y(), 1, 0, 0, -y.z(), 0, y.x(), 0, 1, 0, y.y(), -y.x(), 0, 0, 0, 1;
        const Eigen::Matrix<double, 2, 6> j = d * turn * move;
        h += j.transpose() * j;
        g += j.transpose() * (s.camera.Project(x) - s.pixels[k]);
      }
    }
    h.diagonal().array() += 1e-9 * h.trace() + 1e-300;
    const Eigen::Matrix<double, 6, 1> step = -h.ldlt().solve(g);
    const double angle = step.head<3>().norm();
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    if (angle > 1e-15) rotation = Eigen::AngleAxisd(angle, step.head<3>() / angle);
    motion = {(rotation * motion.rotation).normalized(),
              rotation * motion.translation + step.tail<3>()};
  }
  return motion;
}

/// Of the trials with nearly the most inliers, the one that moves the figure least: on an even
/// turntable a figure turned by one step looks like one that stayed, under the next camera.
int LeastMotion(const std::vector<RigMatch>& trials, const std::vector<int>& sums) {
  const double enough = FindCamerasTuning::kAsGood * *std::max_element(sums.begin(), sums.end());
  int best = -1;
  double least = 1e300;
  for (int t = 0; t < SizeOf(trials); ++t) {
    if (sums[t] < enough) continue;
    const Rigid3& motion = trials[t].rig_from_template;
    const double angle = Eigen::Quaterniond::Identity().angularDistance(motion.rotation);
    if (angle < least) least = angle, best = t;
  }
  return best;
}

}  // namespace

RigMatch MatchRig(const Mesh& mesh, const std::vector<FoundCamera>& cameras,
                  const std::vector<PreparedView>& views, const std::vector<View>& rig) {
  const std::vector<Sightings> sightings = SightingsOf(mesh, cameras, views);
  std::vector<RigMatch> trials;
  for (const FoundCamera& camera : cameras)
    for (const View& view : rig)
      if (camera.found) {
        trials.emplace_back();
        trials.back().rig_from_template =
            Compose(view.camera_from_world.Inverse(), camera.camera_from_world);
      }
  std::vector<int> sums(trials.size());
  ParallelFor(SizeOf(trials), [&](std::int64_t t) { sums[t] = Assign(sightings, rig, trials[t]); });
  RigMatch best;
  if (trials.empty()) return best;
  best = trials[LeastMotion(trials, sums)];
  for (int round = 0; round < 3; ++round) {
    best.rig_from_template = RefinedMotion(sightings, rig, best);
    Assign(sightings, rig, best);
  }
  int together = 0, alone = 0;
  for (int i = 0; i < SizeOf(cameras); ++i)
    together += best.inliers[i], alone += cameras[i].inliers;
  best.found = best.agreeing >= 2 &&
               best.agreeing >= FindCamerasTuning::kLeastAgreeing * SizeOf(sightings) &&
               together >= FindCamerasTuning::kLeastInCommon * alone;
  return best;
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
