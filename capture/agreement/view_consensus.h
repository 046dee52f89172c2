// Which photographs agree in outline; those that contradict the others are outliers.
#pragma once

#include <functional>
#include <vector>

#include "capture/agreement/view_colours.h"
#include "core/image.h"

namespace keypose::capture {

struct ConsensusOptions {
  double missing = 0.03;  ///< a view that lacks this much more of the figure than is usual
                          ///< contradicts the others
  double depth = 0.012;   ///< what is missing counts where it is deeper than this share of the
                          ///< picture's longer side
  /// share of another mask that nothing explains any more once this view counts
  double robbed = 0.01;
  double touching = 0.05;  ///< what lies outside of the others' space, over the figure's area, that
                           ///< is no part of a mask's rim
  double few = 0.25;       ///< share of the views that something may touch; in more it is a stand
  /// share of the views that may be outliers before it cannot be told who is right
  double most_doubtful = 0.34;
};

/// For each mask how many of the other inliers deny all places along a pixel's ray, up to `most`.
struct Denials {
  std::vector<Image8> pictures;
  int most = 0;
};

/// How a mask fits the space that the other masks leave; parts of the figure's area in that
/// picture.
struct OutlineFit {
  static constexpr int kDoubts = 3;
  double missing[kDoubts] = {};  ///< outside of the mask, where no other view, at most one, at most
                                 ///< two deny that there is something
  double excess = 0;             ///< inside of the mask, where `most` others deny it
};

/// @param masks  of the pictures' size
std::vector<OutlineFit> FitsOfOutlines(const std::vector<Image8>& masks, const Denials& denials,
                                       const ConsensusOptions& options);

struct ViewConsensus {
  std::vector<char> inlier;      ///< one a view: 0 contradicts the others
  std::vector<OutlineFit> fits;  ///< to those that are inliers in the end
  std::vector<ColorFit> colors;  ///< likewise
  /// more than most_doubtful would have to go: who is right cannot be told
  bool undecided = false;
};

/// The views whose masks hold something large that the others see past, where few do: a hand that
/// reaches in. Refined masks leave it out.
std::vector<std::size_t> Touched(const ViewConsensus& consensus, const ConsensusOptions& options);

/// Makes outliers of one view after the other, the worst first, until none that is left contradicts
/// the rest. A view that denies what all others (or all but one or two) uphold is at fault, however
/// much of the common space it has carved away: the space is asked without it. What is usual is the
/// median view's: a hull is larger than its figure, and each view sees through some gap that few
/// others see. To look through a gap is no fault: between columns there is space that only few
/// photographs see to be empty. So a view must also rob two others of something: by its denials
/// alone nothing is left along the rays of more than `robbed` of their masks.
/// @param denials     of all views; at the end those of the inliers
/// @param denials_by  asks the space again: one flag a view, 0 for an outlier
/// Same bits for any thread count.
ViewConsensus JudgeOutlines(const std::vector<Image8>& masks, Denials& denials,
                            const std::function<Denials(const std::vector<char>&)>& denials_by,
                            const ConsensusOptions& options);

}  // namespace keypose::capture
