// What depths tell of the figure, photograph by photograph.
#pragma once

#include <vector>

#include "capture/board/board_detection.h"
#include "capture/room/coarse_depths.h"
#include "capture/room/first_masks.h"
#include "capture/room/standing_figure.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct TellByDepthsOptions {
  /// of the figure's size in the picture: what is farther from any depth of it is not the figure;
  /// infinity: it stays open
  double near = 0.08;
  double fattened_px = 4;  ///< so near to a point of the figure, depths behind it are not believed:
                           ///< windows with more texture than a hand hide it
  double fewest = 0.001;   ///< of the picture: with fewer depths of the figure nothing is told
};

/// The figure is where a depth of it is, the room where another is, where the plane is seen, or
/// where no point of the figure is near that any view shows; else it stays open.
/// @param images  at working size, by view
/// @param views   with cameras of that size
/// @param figure  of the same depths
/// @param floor   by view, how like the plane's picture it is, as LikeFloor says
/// @return with the views that show the figure as fitting ones, and no asked ones
ToldFigure TellByDepths(const std::vector<Image8>& images, const std::vector<View>& views,
                        const CoarseDepths& depths, const StandingFigure& figure,
                        const std::vector<Image8>& floor, const TellByDepthsOptions& options = {});

/// What the network said of photographs in which it does not contradict the depths, corrected by
/// them.
/// @param said    masks that fit each other
/// @param depths  told with `near` infinite
/// @return without fitting ones, where too few of them do not contradict the depths
ToldFigure ToldByBoth(const ToldFigure& said, const ToldFigure& depths,
                      const FirstMasksOptions& options = {});

/// What a person's strokes say counts more than depths.
/// @param strokes  by view, or empty
void AddStrokes(const std::vector<ViewStrokes>& strokes, ToldFigure& told);

/// What depths told as known odds: `figure` where the figure is, -`room` where the room is, half of
/// that where it is likely, nothing where it is open or the odds are 0.
BoardOdds KnownOdds(const ToldView& told, double figure, double room);

}  // namespace keypose::capture
