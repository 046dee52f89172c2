// What speaks for cameras, whatever way they were found: outlines and matches that agree with them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reconstruct/matching/colmap_database.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

/// The evidence for the cameras of a scene. Reprojection errors are no part of it: an adjustment
/// makes them small for wrong cameras too.
struct CameraEvidence {
  int images = 0, placed = 0;  ///< photographs, and those with a camera
  bool outlines = false;       ///< there are masks to judge by; without them the rest is 0
  double hull_iou = 0;  ///< overlap of mask and hull of all masks, mean over the views; 0 where the
                        ///< masks have no common space
  double hull_iou_least = 0;
  /// views whose outlines stand out from the others, as HullCheck has it
  std::vector<std::string> disagreeing = {};
  int pairs = 0;        ///< pairs of photographs that verified matches tie, both placed
  int pairs_agree = 0;  ///< of these, where most matches agree with the cameras

  double pairs_agree_share() const {
    return pairs > 0 ? static_cast<double>(pairs_agree) / pairs : 0;
  }
  /// One number in [0, 1] to compare strategies by: the share of photographs placed, times how far
  /// outlines and matches agree.
  double Score() const;
};

/// Below this overlap no camera was ever right, and above it none was far from right:
/// docs/decisions/one-evidence-for-all-cameras.md.
constexpr double kLeastHullOverlap = 0.88;
/// From here on other strategies need not be asked.
constexpr double kSureHullOverlap = 0.89;
/// Of pairs tied by matches, that must agree for cameras to be sure. Pairs are few on weak texture;
/// fewer than this many say nothing.
constexpr double kSurePairShare = 0.7;
constexpr int kFewestPairs = 8;

/// Whether the outlines allow the cameras at all; without masks nothing speaks against any.
bool CanBeRight(const CameraEvidence& evidence);
/// Whether outlines and matches leave no doubt.
bool IsSure(const CameraEvidence& evidence);

/// Whether `other` is to be taken instead of `best`, which was found by a strategy that comes
/// first: where it alone can be right, where it places more photographs and can be right too, or
/// where the evidence for it is clearly better.
bool IsBetter(const CameraEvidence& other, const CameraEvidence& best);

/// Where a hull lies.
struct HullBox {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
};

/// Counts the pairs of placed photographs whose verified matches agree with the cameras: for most
/// of them, each match must lie within `max_error_px` of its epipolar line, and the lines of sight
/// must meet in or near the hull. The second tells a wrong turn of the table, which slides matches
/// along their epipolar lines.
///
/// @param verified  matches that fit a fundamental matrix, by images
/// @param view_of_image  index into scene.views, or -1
void CountAgreeingPairs(const Scene& scene, const std::vector<int>& view_of_image,
                        const std::vector<Features>& features,
                        const std::vector<PairMatches>& verified, const HullBox& hull,
                        double max_error_px, CameraEvidence& evidence);

/// Outlines against their hull, on a grid of 96 cells: adds hull_iou, hull_iou_least and
/// disagreeing.
/// @param views  masks without colour, a few hundred pixels wide, at least 3
/// @return where the hull is; nothing when the masks have no common space, which leaves an overlap
/// of 0
std::optional<HullBox> MeasureOutlines(const std::vector<PreparedView>& views,
                                       CameraEvidence& evidence);

}  // namespace keypose::reconstruct
