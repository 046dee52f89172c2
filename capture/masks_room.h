// What is the figure, where photographs show a room: part of keypose-masks.
#pragma once

#include <string>
#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/board/board_detection.h"
#include "capture/segmentation/mask_options.h"
#include "core/io/pictures/image_set.h"
#include "core/stage/stage.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

/// The photographs that have a camera, by view, at working size.
struct FigureSet {
  const std::vector<View>& views;
  const std::vector<SparsePoint>& points;
  const std::vector<Image8>& images;
  std::vector<BoardOdds>& known;  ///< odds by a printed board, and then by what FindFigure sees
  const std::vector<std::size_t>& index;  ///< of each view's photograph in the set
  const ImageSet& set;
  MaskOptions masking;
  std::string strokes;  ///< as core/values/figure_strokes.h reads them
};

struct FoundFigure {
  bool in_room = false;          ///< the photographs show a room, or a person said something
  bool stands = false;           ///< depths show that it stands free on a plane
  std::vector<double> hidden{};  ///< by view: share of the figure behind other things, or empty
};

/// Replaces the masks where the photographs show a room and the masks are doubtful, or where a
/// person said what the figure is: by strokes and by the network's opinion of a few photographs.
/// Sets the floor, which nothing of the figure is below. Reports in_room, points_around,
/// floor_in_masks, figure_by, figure_asked, figure_told, masks_left_by_others, masks_like_told.
/// @param masks  as capture made them; those that a person made stay
/// @throws InputError  what is the figure cannot be told; a sheet of what was taken for it is then
/// left as FailurePicture of `masked`
FoundFigure FindFigure(StageContext& stage, const FigureSet& figures, SpaceOptions& space,
                       std::vector<Image8>& masks);

/// Warns where masks of a room do not agree well, and refuses where they do not agree at all, or
/// where the figure does not stand free and no person said what it is. Reports figure_unclear,
/// goes_on_beside, goes_on_beyond. Warns, too, where the masks are not what a person said;
/// reports photographs_unlike_said.
/// @throws InputError  as said, with such a sheet
void RequireClearFigure(StageContext& stage, const FigureSet& figures, const SpaceOptions& space,
                        const FoundFigure& found, const std::vector<Image8>& masks);

}  // namespace keypose::capture
