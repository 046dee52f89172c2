#include "fit/cameras/rig_motions.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth), the last on the plush dog.
struct RigMotionTuning {
  KEYPOSE_TUNED(double, kAsGood, 0.85);        // share of the most inliers that is as good
  KEYPOSE_TUNED(double, kLeastAgreeing, 0.6);  // share of the photographs
  // Inliers under the rig's cameras, over those under cameras found one by one.
  KEYPOSE_TUNED(double, kLeastInCommon, 0.7);
  // Distance of corners, over the diagonal, from which on two motions are not the same.
  KEYPOSE_TUNED(double, kAnother, 0.03);
};

/// Of the trials with nearly the most inliers, the one that moves the figure least.
int LeastMotion(const std::vector<RigMotion>& trials, const std::vector<int>& sums) {
  const double enough = RigMotionTuning::kAsGood * *std::max_element(sums.begin(), sums.end());
  int best = -1;
  double least = 1e300;
  for (int t = 0; t < SizeOf(trials); ++t) {
    if (sums[t] < enough) continue;
    const Rigid3& motion = trials[t].rig_from_template;
    const double angle = Eigen::Quaterniond::Identity().angularDistance(motion.rotation);
    if (angle < least) {
      least = angle;
      best = t;
    }
  }
  return best;
}

/// Mean distance between the corners of the mesh's box after two motions, over its diagonal.
double Between(const Mesh& mesh, const Rigid3& a, const Rigid3& b) {
  const Eigen::Vector3d low = mesh.points.colwise().minCoeff(),
                        high = mesh.points.colwise().maxCoeff();
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p(corner & 1 ? low.x() : high.x(), corner & 2 ? low.y() : high.y(),
                            corner & 4 ? low.z() : high.z());
    sum += (a * p - b * p).norm();
  }
  return sum / (8 * (high - low).norm());
}

bool IsNew(const Mesh& mesh, const RigMotion& motion, const std::vector<RigMotion>& known) {
  return std::all_of(known.begin(), known.end(), [&](const RigMotion& other) {
    return Between(mesh, motion.rig_from_template, other.rig_from_template) >
           RigMotionTuning::kAnother;
  });
}

class MotionSearch {
 public:
  MotionSearch(const Mesh& mesh, const std::vector<FoundCamera>& cameras,
               const std::vector<PreparedView>& views, const std::vector<View>& rig)
      : mesh_(mesh), rig_(rig), sightings_(SightingsOf(mesh, cameras, views)) {
    for (const FoundCamera& camera : cameras) {
      alone_ += camera.inliers;
      if (!camera.found) continue;
      for (const View& view : rig) {
        trials_.emplace_back();
        trials_.back().rig_from_template =
            Compose(view.camera_from_world.Inverse(), camera.camera_from_world);
      }
    }
    sums_.resize(trials_.size());
    ParallelFor(SizeOf(trials_),
                [&](std::int64_t t) { sums_[t] = Assign(sightings_, rig, trials_[t]); });
  }

  std::vector<RigMotion> Run() {
    if (trials_.empty()) return {};
    RigMotion first = Refined(trials_[LeastMotion(trials_, sums_)]);
    const int together = std::accumulate(first.inliers.begin(), first.inliers.end(), 0);
    first.clear = first.agreeing >= kFewest &&
                  first.agreeing >= RigMotionTuning::kLeastAgreeing * SizeOf(sightings_) &&
                  together >= RigMotionTuning::kLeastInCommon * alone_;
    std::vector<RigMotion> motions = {first};
    RigMotion stayed;
    Assign(sightings_, rig_, stayed);
    if (first.clear && !IsNew(mesh_, stayed, motions)) return motions;
    if (stayed.agreeing >= kFewest) motions.push_back(stayed);
    if (const RigMotion common = MostCommon();
        2 * common.agreeing >= SizeOf(sightings_) && IsNew(mesh_, common, motions))
      motions.push_back(common);
    return motions;
  }

 private:
  static constexpr int kFewest = 2;

  RigMotion Refined(RigMotion motion) const {
    for (int round = 0; round < 3; ++round) {
      motion.rig_from_template = Improved(sightings_, rig_, motion);
      Assign(sightings_, rig_, motion);
    }
    return motion;
  }

  /// Of different trials, refined, the one with which most photographs agree.
  RigMotion MostCommon() const {
    constexpr int kMostRivals = 12;
    std::vector<int> order(trials_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return CommonMatches(trials_[a]) > CommonMatches(trials_[b]);
    });
    std::vector<RigMotion> rivals;
    for (const int t : order) {
      if (!IsNew(mesh_, trials_[t], rivals)) continue;
      rivals.push_back(trials_[t]);
      if (SizeOf(rivals) == kMostRivals) break;
    }
    ParallelFor(SizeOf(rivals), [&](std::int64_t r) { rivals[r] = Refined(rivals[r]); });
    return *std::max_element(rivals.begin(), rivals.end(), [](const auto& a, const auto& b) {
      return std::pair(a.agreeing, CommonMatches(a)) < std::pair(b.agreeing, CommonMatches(b));
    });
  }

  /// Matches that agree; no photograph outvotes the others.
  static int CommonMatches(const RigMotion& motion) {
    int sum = 0;
    for (const int inliers : motion.inliers) sum += std::min(inliers, kLeastOnRig + 4);
    return sum;
  }

  const Mesh& mesh_;
  const std::vector<View>& rig_;
  std::vector<Sightings> sightings_;
  std::vector<RigMotion> trials_;
  std::vector<int> sums_;  // inliers of each trial
  int alone_ = 0;          // inliers of the cameras that were found one by one
};

}  // namespace

std::vector<RigMotion> FindRigMotions(const Mesh& mesh, const std::vector<FoundCamera>& cameras,
                                      const std::vector<PreparedView>& views,
                                      const std::vector<View>& rig) {
  return MotionSearch(mesh, cameras, views, rig).Run();
}

std::vector<FoundCamera> CamerasUnder(const RigMotion& motion, const std::vector<View>& rig,
                                      std::vector<FoundCamera> cameras) {
  for (int i = 0; i < SizeOf(cameras); ++i) {
    cameras[i].found = motion.rig_view[i] >= 0;
    if (cameras[i].found) cameras[i].camera_from_world = rig[motion.rig_view[i]].camera_from_world;
  }
  return cameras;
}

}  // namespace keypose::fit
