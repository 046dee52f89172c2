// Agreement of cameras with outlines and matches, for all strategies alike.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/tuned.h"
#include "reconstruct/matching/colmap_database.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

/// The evidence for the cameras of a scene. It does not include reprojection errors: bundle
/// adjustment makes them small for wrong cameras too.
struct CameraEvidence {
  int images = 0, placed = 0;  ///< photographs, and those with a camera
  bool outlines = false;  ///< there are masks to compare with; without them the values below are 0
  double hull_iou = 0;  ///< overlap of each mask with the hull of all masks, mean over the views; 0
                        ///< where the masks have no common space
  double hull_iou_least = 0;
  /// the masks were compared without their holes, which agree better so: dark gaps are holes in
  /// some masks and parts of the figure in others
  bool holes_filled = false;
  /// views whose outlines differ from the others' (see HullCheck)
  std::vector<std::string> disagreeing = {};
  /// the cameras were placed by whole photographs: matches all over the picture judge them, and
  /// masks, which are doubtful in a room, do not
  bool by_surroundings = false;
  int pairs = 0;        ///< pairs of placed photographs with verified matches
  int pairs_agree = 0;  ///< of these, the pairs most of whose matches agree with the cameras

  double pairs_agree_share() const {
    return pairs > 0 ? static_cast<double>(pairs_agree) / pairs : 0;
  }
  /// One number in [0, 1] to compare strategies by: the share of photographs placed, times the
  /// agreement of outlines and matches.
  double Score() const;
};

/// Tuned on eight synthetic sets, the plush dog and the skull, and on wrong cameras of a heap of
/// balls and of a ring with two photographs upside down
/// (docs/algorithms/sfm.md). Sensitivity: docs/results/sensitivity.md.
struct CameraEvidenceTuning {
  /// IoU; in tests, no cameras below this overlap were right, and none above it far from right
  KEYPOSE_TUNED(double, kLeastHullOverlap, 0.88);
  /// IoU; from this overlap on, no other strategy is tried
  KEYPOSE_TUNED(double, kSureHullOverlap, 0.89);
  /// least share of agreeing pairs for cameras to be sure
  KEYPOSE_TUNED(double, kSurePairShare, 0.7);
  /// In a room: agreeing pairs for each photograph; in small sets this share of all pairs
  KEYPOSE_TUNED(double, kPairsOfEach, 2.5);
  KEYPOSE_TUNED(double, kShareOfAll, 0.5);
  /// On weak texture pairs are few; fewer than these are not conclusive.
  KEYPOSE_TUNED(int, kFewestPairs, 8);
  KEYPOSE_TUNED(double, kPairWeight, 0.3);  ///< of the agreeing pairs in the score; the rest is 1
  KEYPOSE_TUNED(double, kClearly, 0.02);    ///< score by which other evidence is clearly better
  KEYPOSE_TUNED(double, kAround, 0.1);  ///< of the hull's size: matches meet at most so far off it
};

/// Whether the cameras are consistent with the outlines; without masks always true.
bool IsPlausible(const CameraEvidence& evidence);
/// Whether outlines and matches confirm the cameras.
bool IsSure(const CameraEvidence& evidence);

/// Whether `other` is better than `best`, which an earlier strategy found: when only `other` can be
/// right, when it can be right and places more photographs, or when its evidence is clearly better.
bool IsBetter(const CameraEvidence& other, const CameraEvidence& best);

/// Bounding box of a visual hull.
struct HullBox {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
};

/// Whether most matches of each pair agree with its two cameras: 1 or 0, -1 where one of the two is
/// not placed. As CountAgreeingPairs, but matches may meet anywhere before both cameras.
std::vector<char> AgreementOfPairs(const Scene& scene, const std::vector<int>& view_of_image,
                                   const std::vector<Features>& features,
                                   const std::vector<PairMatches>& verified, double max_error_px);

/// Counts the pairs of placed photographs whose verified matches agree with the cameras. For most
/// matches of such a pair, each match lies within `max_error_px` of its epipolar line, and the rays
/// intersect in or near the hull. The second condition detects a wrong rotation of the table, which
/// moves matches along their epipolar lines.
///
/// @param verified  matches that fit a fundamental matrix, by images
/// @param view_of_image  index into scene.views, or -1
void CountAgreeingPairs(const Scene& scene, const std::vector<int>& view_of_image,
                        const std::vector<Features>& features,
                        const std::vector<PairMatches>& verified, const HullBox& hull,
                        double max_error_px, CameraEvidence& evidence);

/// Compares outlines with their hull, on a grid of 96 cells: sets hull_iou, hull_iou_least and
/// disagreeing. Where the cameras would not be sure, the masks are compared without their holes
/// too, and the better agreement counts.
/// @param views  masks without colour, a few hundred pixels wide, at least 3
/// @return the hull's bounds; nothing when the masks have no common space, which leaves an overlap
/// of 0
std::optional<HullBox> MeasureOutlines(const std::vector<PreparedView>& views,
                                       CameraEvidence& evidence);

}  // namespace keypose::reconstruct
