// Options of the space that the masks of a set share.
#pragma once

#include <limits>
#include <vector>

#include "capture/agreement/view_colours.h"
#include "capture/agreement/view_consensus.h"
#include "core/values/image.h"

namespace keypose::capture {

struct SpaceOptions {
  int resolution = 128;  ///< voxels along the longest side of the space that the masks share
  /// largest number of contradictions that is counted exactly, fewer in sets below 48 views
  int most_contradictions = 8;
  /// a mask contradicts points that project outside of it by more than this
  double margin_px = 1;
  double weight = 2;  ///< of the others' contradictions relative to the photograph's own odds
  /// share of the views that must see a point; else it counts as contradicted by all
  double least_seen = 1.0 / 3;
  /// height of the floor, below which nothing is the figure (z, in the cameras' frame); by default
  /// there is none
  double floor = -std::numeric_limits<double>::infinity();
  /// the masks need no new segmentation: others' contradictions alone correct them
  bool segmented = false;
  /// by view, of any size: 255 where something else hides what is behind it, so that a mask tells
  /// nothing; empty where nothing does
  std::vector<Image8> hidden{};
  ConsensusOptions consensus{};
  ColorOptions colors{};
};

}  // namespace keypose::capture
