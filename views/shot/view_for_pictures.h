// The camera of a film whose pictures are not those that it was calibrated with.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose {

/// A view for a film's pictures, and what was assumed for it.
struct AdjustedView {
  View view;
  std::string note;  ///< one sentence for the user; empty: the pictures have the calibrated size
};

/// The view of a film whose pictures an encoder scaled, cut, set between black borders, or turned
/// upright. In this order, the first that fits:
/// - the same size, or a size that is not known: as calibrated;
/// - the same shape to a pixel: scaled;
/// - black rows at top and bottom, or black columns at both sides, as wide as the whole calibrated
///   picture leaves them free in the film's size: scaled and set between them, by the borders that
///   the picture shows;
/// - smaller by at most 16 pixels each way: cut; scaled so that one side fits, the other one
///   smaller by at most 16 calibrated pixels: scaled and cut. The cut is taken at the right and at
///   the bottom, where encoders cut pictures to whole blocks;
/// - any of these after a quarter turn, by the direction that brings the world's up to the top.
///
/// @param calibrated  its size may be 0: not known
/// @param picture     one of the film's, as evidence for borders; a mask has none
/// @param up          the world's up; empty: not known, turned films are refused
/// @param stage       its name, for messages
/// @throws InputError  nothing fits; names both sizes and the cure
AdjustedView ViewForPictures(const View& calibrated, const Image8& picture,
                             const std::optional<Eigen::Vector3d>& up, const std::string& stage);

/// The view after the picture was turned clockwise by a quarter.
View TurnedClockwise(const View& view);

}  // namespace keypose
