// Detects photographs whose outlines are inconsistent with the others: outliers.
#pragma once

#include <functional>
#include <vector>

#include "capture/agreement/view_colours.h"
#include "core/values/image.h"

namespace keypose::capture {

struct ConsensusOptions {
  double missing = 0.03;  ///< a view is an outlier candidate if its missing part of the figure
                          ///< exceeds the median by this
  double depth = 0.012;   ///< missing parts count if they are thicker than this share of the
                          ///< picture's longer side
  /// least share of another mask whose rays are left without space by this view alone
  double robbed = 0.01;
  double touching = 0.05;  ///< largest part of a mask outside of the others' space, over the
                           ///< figure's area, that is not yet counted as a touching object
  /// largest share of the views with a touching object; in more views it is a support
  double few = 0.25;
  /// largest share of outliers for which the consensus is still reliable
  double most_doubtful = 0.34;
};

/// For each mask, the smallest number of contradictions by other inliers along each pixel's ray, up
/// to `most`.
struct Contradictions {
  std::vector<Image8> pictures;
  int most = 0;
};

/// Differences between a mask and the space of the other masks, as shares of the figure's area in
/// that picture.
struct OutlineFit {
  static constexpr int kDoubts = 3;
  double missing[kDoubts] = {};  ///< outside of the mask, at pixels with contradictions by no other
                                 ///< view, by at most one, and by at most two
  double excess = 0;             ///< inside of the mask, at pixels with `most` contradictions
};

/// @param masks  of the pictures' size
std::vector<OutlineFit> FitsOfOutlines(const std::vector<Image8>& masks,
                                       const Contradictions& contradictions,
                                       const ConsensusOptions& options);

struct ViewConsensus {
  std::vector<char> inlier;      ///< one per view: 0 for an outlier
  std::vector<OutlineFit> fits;  ///< relative to the final inliers
  std::vector<ColorFit> colors;  ///< likewise
  /// there would be more outliers than most_doubtful: no reliable consensus
  bool undecided = false;
};

/// The views whose masks contain a large object outside of the others' space, if they are few: a
/// hand that reaches in. Refined masks exclude it.
std::vector<std::size_t> Touched(const ViewConsensus& consensus, const ConsensusOptions& options);

/// Marks views as outliers one by one, the worst first, until the remaining ones are consistent. A
/// view's mask may lack a part that no other view, or at most one or two, contradicts. Then the
/// view is at fault, even if it has carved away much of the common space, because the space is
/// computed without it. Its missing part is compared with the median view's, since a hull is larger
/// than its figure and each view sees through gaps that few others see. Seeing through a gap is no
/// fault: between columns there is space that only few photographs show to be empty. So an outlier
/// must also affect at least two other views: its contradictions alone remove all space along the
/// rays of more than `robbed` of their masks.
/// @param contradictions     of all views; on return those of the inliers
/// @param contradictions_by  computes the contradictions for given inliers: one flag per view, 0
/// for an outlier Same bits for any thread count.
ViewConsensus CheckOutlines(
    const std::vector<Image8>& masks, Contradictions& contradictions,
    const std::function<Contradictions(const std::vector<char>&)>& contradictions_by,
    const ConsensusOptions& options);

}  // namespace keypose::capture
