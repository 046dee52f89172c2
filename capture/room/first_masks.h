// First masks of photographs taken in a room: a few pictures that the network or a person told
// about, carried to all photographs through the cameras and by colours.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/board/board_detection.h"
#include "capture/room/asked_views.h"
#include "capture/room/stroke_masks.h"
#include "capture/segmentation/mask_options.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::capture {

struct FirstMasksOptions {
  int ask = 5;        ///< photographs that the network sees
  int few = 12;       ///< sets of at most so many photographs are shown whole
  double same = 0.5;  ///< least share of a told mask that the others leave of it
  int fewest = 3;     ///< told photographs that must fit each other
};

/// What is told of a pixel.
enum Told : std::uint8_t {
  kNotTold,
  kToldRoom,
  kToldLikelyRoom,
  kToldOpen,
  kToldFigure,
  kToldKinds
};

/// What was told of one photograph.
struct ToldView {
  Image8 mask;   ///< 255 where the figure is likely; empty: nothing was told
  Image8 kinds;  ///< Told, pixel by pixel; of the mask's size
};

struct ToldFigure {
  std::vector<ToldView> views;  ///< by view
  std::vector<int> asked;       ///< views that the network saw, or that have strokes
  std::vector<int> fitting;     ///< of these, those whose masks fit each other; none: unclear
  /// a person's strokes show that the network takes other things for the figure: only photographs
  /// with strokes count
  bool network_errs = false;
  /// what is told is in many pieces: of each mask, all regions stay in which the figure was told
  bool in_pieces = false;
};

/// Asks the network about some photographs, and takes up what a person said.
/// @param images    RGB at working size, by view
/// @param views     with cameras of that size
/// @param middle    a point on or near the figure
/// @param turns     by view: quarter turns, clockwise, that put its picture upright
/// @param strokes   by view; empty, or one for each
/// @param salience  may be empty, when strokes alone tell
/// @param space     with the floor, under which nothing is the figure
ToldFigure AskAboutFigure(const std::vector<Image8>& images, const std::vector<View>& views,
                          const Eigen::Vector3d& middle, const std::vector<int>& turns,
                          const std::vector<ViewStrokes>& strokes, const Salience& salience,
                          const SpaceOptions& space, const FirstMasksOptions& options = {},
                          Progress* progress = nullptr);

/// Masks of all photographs, by the colours that the fitting ones teach and within their space.
/// @param told  with fitting views
/// Same bits for any thread count.
std::vector<Image8> CarryToAll(const std::vector<Image8>& images, const std::vector<View>& views,
                               const ToldFigure& told, const std::vector<BoardOdds>& boards,
                               const MaskOptions& masking, const SpaceOptions& space);

/// How much of each mask the others leave: the share of its pixels that at most one of them sees
/// past. Zeros where there is no common space.
/// @param views  3 or more
std::vector<double> LeftByOthers(const std::vector<View>& views, const std::vector<Image8>& masks,
                                 const SpaceOptions& space);

}  // namespace keypose::capture
