// First masks of photographs taken in a room: a few pictures that the network or a person told
// about, carried to all photographs through the cameras and by colours.
#pragma once

#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/board/board_detection.h"
#include "capture/room/asked_views.h"
#include "capture/room/stroke_masks.h"
#include "capture/segmentation/mask_options.h"
#include "core/camera.h"
#include "core/image.h"
#include "core/progress.h"

namespace keypose::capture {

struct FirstMasksOptions {
  int ask = 5;        ///< photographs that the network sees
  double same = 0.5;  ///< least overlap of a told mask with what the others leave of it
  int fewest = 3;     ///< told photographs that must fit each other
};

struct FirstMasks {
  std::vector<Image8> masks;  ///< by view; empty where too few told photographs fit each other
  std::vector<int> told;      ///< views whose own masks were told and fit
  std::vector<int> asked;     ///< views that the network saw
  bool unclear = false;       ///< what was told does not fit
};

/// @param images    RGB at working size, by view
/// @param views     with cameras of that size; z = 0 is the floor if options.floor is set
/// @param middle    a point on or near the figure
/// @param strokes   by view; empty, or one for each
/// @param salience  may be empty, when strokes alone tell
/// @param space     with the floor, under which nothing is the figure
/// Same bits for any thread count.
FirstMasks MakeFirstMasks(const std::vector<Image8>& images, const std::vector<View>& views,
                          const Eigen::Vector3d& middle, const std::vector<ViewStrokes>& strokes,
                          const std::vector<BoardOdds>& boards, const Salience& salience,
                          const MaskOptions& masking, const SpaceOptions& space,
                          const FirstMasksOptions& options = {}, Progress* progress = nullptr);

}  // namespace keypose::capture
