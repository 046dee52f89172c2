// Options of the space that the masks of a set share.
#pragma once

#include "capture/agreement/view_colours.h"
#include "capture/agreement/view_consensus.h"

namespace keypose::capture {

struct SpaceOptions {
  int resolution = 128;  ///< voxels along the longest side of the space that the masks share
  int most_denials = 8;  ///< views against a place that are told apart, fewer in sets below 48;
                         ///< more count as this many
  /// a mask denies a place that it shows outside of itself by more than this
  double margin_px = 1;
  double weight = 2;  ///< of the denials by others against what the photograph shows
  ConsensusOptions consensus{};
  ColorOptions colors{};
};

}  // namespace keypose::capture
