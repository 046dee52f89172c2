// Which surface in a room is the figure: what stands on the plane below what the cameras look at.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "capture/room/coarse_depths.h"
#include "capture/room/stroke_masks.h"
#include "capture/room/support_planes.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct StandingOptions {
  SupportOptions plane;
  double voxel = 0.006;  ///< of the cameras' distance
  double reach = 0.8;    ///< of that distance: what is farther from the middle is not the figure
  double round = 0.5;    ///< least share of the foot's surroundings that are plane
  double afloat = 0.03;  ///< of the cameras' distance above the plane: a piece stands on nothing
  double joins = 0.5;    ///< least share of the opinions on such a piece
  double tall =
      0.5;  ///< of the height above the lowest plane: a figure on a higher one has so much
};

/// What a sample of a surface belongs to.
enum class SampleLabel : std::uint8_t { kOpen, kFigure, kSupport, kOther };

struct StandingFigure {
  std::vector<std::vector<SampleLabel>> samples;  ///< by view, as the depths' samples
  std::vector<Eigen::Vector3d> points;            ///< of its surface, evenly spread
  std::vector<Eigen::Vector3d> others;            ///< of other things on the plane, likewise
  double spacing = 0;                             ///< of these points
  Support support;
  double height = 0;     ///< of the figure's highest point above the plane
  bool on_wall = false;  ///< the plane is a wall, and the figure a relief on it
};

/// What is known of the figure beside the depths.
struct Opinions {
  std::vector<Image8> masks;         ///< by view, of the figure; empty where there is none
  std::vector<ViewStrokes> strokes;  ///< by view, or empty: what a person said
};

/// Finds the plane that has most of the surface around the middle, or the highest one parallel to
/// it on which most of what stands there stands; and the connected surface above it that is nearest
/// to the middle's axis, with pieces that stand on nothing, as a head above a dark neck, and that
/// masks have. A person's strokes say which surface it is, and which part of it is another thing.
/// @return nothing where there is no plane, nothing stands on it, or what does goes on beyond reach
/// Same bits for any thread count.
std::optional<StandingFigure> FindStandingFigure(const CoarseDepths& depths,
                                                 const std::vector<View>& views,
                                                 const Eigen::Vector3d& middle,
                                                 const Opinions& opinions,
                                                 const StandingOptions& options = {});

}  // namespace keypose::capture
