// A pose for every frame of a performance, one after the other.
#pragma once

#include <optional>
#include <vector>

#include "motion/tracking/pose_search.h"

namespace keypose::motion {

/// Found on the generated performance with seeds 101 and 102.
struct TrackerTuning {
  KEYPOSE_TUNED(int, kRounds, 4);            ///< of new contours in a frame
  KEYPOSE_TUNED(double, kSpeed, 0.8);        ///< share of the last frame's motion that goes on
  KEYPOSE_TUNED(double, kLostOutside, 0.3);  ///< share of a limb outside of the masks
  KEYPOSE_TUNED(double, kLostChange, 1.2);   ///< factor on the usual difference to the masks
  KEYPOSE_TUNED(double, kChanged, 0.06);     ///< of the usual difference: worth another search
  KEYPOSE_TUNED(double, kFound, 0.98);       ///< least gain of a search: factor on the difference
  KEYPOSE_TUNED(double, kBackwards, 0.15);   ///< [rad] of an elbow or knee: surely the wrong way
  KEYPOSE_TUNED(double, kAsGood, 1.03);      ///< factor on the difference of a limb turned around
};

struct TrackedFrame {
  BodyPose pose;
  DofVector deviations;  ///< standard deviations of the 38 numbers; StandardDeviations
  PoseSystem evidence;   ///< FrameEvidence at `pose`
  Coverage coverage;
  double unexplained = 0;   ///< share of the outlines that no part of the template is near
  std::vector<Limb> found;  ///< limbs that were lost and searched for with success
};

/// What a frame by itself tells about its pose, without the frames before: outlines [px^2], limits,
/// overlaps and the rest pose, linearised at `fit.pose`, in the chart of the recharted pose.
PoseSystem FrameEvidence(const PoseFit& fit, const BodyShape& shape);

/// What a fit tells of a frame: all but coverage and limbs found.
TrackedFrame FrameOf(const PoseFit& fit, const BodyShape& shape);

class Tracker {
 public:
  /// @param start  a pose near that of the first frame
  Tracker(const BodyShape& shape, const BodyPose& start);
  /// The pose in the next frame.
  TrackedFrame Next(const std::vector<Silhouette>& silhouettes);

 private:
  BodyPose Predicted() const;
  std::vector<QuadraticPrior> Priors(const Eigen::Quaterniond& chart) const;
  std::vector<Limb> Suspects(const Coverage& coverage) const;
  /// Whether a search may find what the limb's last one did not.
  bool WorthSearching(Limb limb, double difference) const;
  void FindLost(const std::vector<Silhouette>& silhouettes, const PoseOptions& options,
                PoseFit* fit, TrackedFrame* frame);
  void TurnBentBackwards(const std::vector<Silhouette>& silhouettes, const PoseOptions& options,
                         PoseFit* fit, TrackedFrame* frame);

  BodyShape shape_;
  LocalSurface surface_;
  BodyPose start_;
  std::vector<BodyPose> before_;  ///< the last two, newest last
  double usual_ = 0;              ///< difference to the masks over both; falls fast, rises slowly
  std::array<int, 4> searched_ = {-100, -100, -100, -100};  ///< frame of each limb's last search
  std::array<double, 4> in_vain_ = {};  ///< relative difference when it found nothing, else 0
  int frame_ = 0;
};

}  // namespace keypose::motion
