// Which photographs contradict the others in outline, and so lose their say.
#pragma once

#include <functional>
#include <vector>

#include "capture/view_colors.h"
#include "core/image.h"

namespace keypose::capture {

struct StandingOptions {
  double missing = 0.03;        ///< a view that lacks this much more of the figure than is usual contradicts the others
  double depth = 0.012;         ///< what is missing counts where it is deeper than this share of the picture's longer side
  double robbed = 0.01;         ///< share of another mask that nothing explains any more once this view is heard
  double touching = 0.05;       ///< what lies outside of the others' space, over the figure's area, that is no part of a mask's rim
  double few = 0.25;            ///< share of the views that something may touch; in more it is a stand
  double most_doubtful = 0.34;  ///< share of the views that may lose their say before it cannot be told who is right
};

/// For each mask how many of the other views that are heard deny all places along a pixel's ray, up to `most`.
struct Denials {
  std::vector<Image8> pictures;
  int most = 0;
};

/// How a mask fits the space that the other masks leave; parts of the figure's area in that picture.
struct OutlineFit {
  static constexpr int kDoubts = 3;
  double missing[kDoubts] = {};  ///< outside of the mask, where no other view, at most one, at most two deny that there is something
  double excess = 0;             ///< inside of the mask, where `most` others deny it
};

/// @param masks  of the pictures' size
std::vector<OutlineFit> FitsOfOutlines(const std::vector<Image8>& masks, const Denials& denials, const StandingOptions& options);

struct Standing {
  std::vector<char> say;         ///< one a view: 0 contradicts the others
  std::vector<OutlineFit> fits;  ///< to those that have a say in the end
  std::vector<ColorFit> colors;  ///< likewise
  bool undecided = false;        ///< more than most_doubtful would have to go: who is right cannot be told
};

/// The views whose masks hold something large that the others see past, where few do: a hand that reaches in. Refined masks leave it out.
std::vector<std::size_t> Touched(const Standing& standing, const StandingOptions& options);

/// Takes the say from one view after the other, the worst first, until none that is left contradicts the rest. A view that denies what
/// all others (or all but one or two) uphold is at fault, however much of the common space it has carved away: the space is asked without
/// it. What is usual is the median view's: a hull is larger than its figure, and each view sees through some gap that few others see.
/// To look through a gap is no fault: between columns there is space that only few photographs see to be empty. So a view must also rob
/// two others of something: by its word alone nothing is left along the rays of more than `robbed` of their masks.
/// @param denials     with all views heard; at the end those with the views that keep their say
/// @param denials_by  asks the space again: one flag a view, 0 is not heard
/// Same bits for any thread count.
Standing JudgeOutlines(const std::vector<Image8>& masks, Denials& denials,
                       const std::function<Denials(const std::vector<char>&)>& denials_by, const StandingOptions& options);

}  // namespace keypose::capture
