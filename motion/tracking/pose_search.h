// Poses from nothing, or of limbs that were lost: many candidates are drawn and compared with the
// masks.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/values/progress.h"
#include "motion/tracking/pose_solver.h"

namespace keypose::motion {

/// The four limbs.
enum class Limb { kLeftArm, kRightArm, kLeftLeg, kRightLeg };
inline constexpr std::array<Limb, 4> kLimbs{Limb::kLeftArm, Limb::kRightArm, Limb::kLeftLeg,
                                            Limb::kRightLeg};
/// Bits of its segments.
std::uint32_t SegmentsOf(Limb limb);

/// How much of the masks the template covers, over all views, in cells of SegmentRaster.
struct Coverage {
  double both = 0, body_only = 0, mask_only = 0;
  std::array<double, 4> limb = {};          ///< cells of each limb where no other segment is
  std::array<double, 4> limb_outside = {};  ///< of these, outside of the masks
  double IoU() const { return both / std::max(1.0, both + body_only + mask_only); }
  double Difference() const { return body_only + mask_only; }
};
Coverage CoverageOf(const std::vector<Silhouette>& silhouettes, const LocalSurface& surface,
                    const PosedBody& body);

/// Looks for one limb over all its directions and bends, the rest of the body fixed.
/// @return the `keep` best poses that differ, best first; the given one may be among them
/// Cost: about 1,000 coarse drawings of two segments in each view, and fewer of the third.
/// Source: Carranza et al., SIGGRAPH 2003, section 5.3 (regular samples, then the best one
/// refined).
std::vector<BodyPose> SearchLimb(const std::vector<Silhouette>& silhouettes, const BodyShape& shape,
                                 const LocalSurface& surface, const BodyPose& pose, Limb limb,
                                 int keep);

/// How far the elbow or knee of a limb is bent beyond straight, the way that it cannot [rad].
double BentBackwards(const BodyPose& pose, Limb limb);
/// The same limb, turned half around its own axis with its hinge bent the other way: of a straight
/// limb outlines do not tell the two apart, so that one that was followed through straight may be
/// bent backwards.
BodyPose TurnedAround(const BodyPose& pose, Limb limb);

/// What the masks alone tell of the actor: the voxels that no view rules out.
struct CoarseHull {
  Eigen::Vector3d low, high, middle;  ///< [m], in a frame with z up
  int voxels = 0;
};
/// @param up_from_world  turns the world's up onto z
/// @return voxels == 0: the views agree on nothing
CoarseHull FindCoarseHull(const std::vector<Silhouette>& silhouettes,
                          const Eigen::Quaterniond& up_from_world);

/// Poses that explain the first frame: headings and arm heights by drawing, the best of them
/// solved, limbs searched for.
/// @param shape  of about the actor's size
/// @param keep   poses that look in different directions
/// @return best first: what an average body cannot tell, such as front and back, a fit of the shape
/// to each may decide
std::vector<BodyPose> SearchPoses(const std::vector<Silhouette>& silhouettes,
                                  const CoarseHull& hull, const Eigen::Quaterniond& up_from_world,
                                  const BodyShape& shape, int keep, Progress* progress = nullptr);

}  // namespace keypose::motion
