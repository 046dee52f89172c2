// Options of the segmentation of a set.
#pragma once

namespace keypose::capture {

struct MaskOptions {
  int working_px = 512;        ///< longer side of the images that are segmented
  int rounds = 4;              ///< segmentations; each but the first learns from the previous one
  double border_share = 0.06;  ///< width of the band along the borders over the image's longer side
  double smoothness = 12;  ///< cost of a border between two pixels of the same colour, in log odds
  double odds_limit = 6;   ///< largest weight of one pixel, in log odds
  /// The estimated empty set is used if it differs from the visible background by at most this [8
  /// bit Lab].
  double largest_misfit = 6;
  /// Distance from the clean plate at which object and background are equally likely [CIE Lab].
  double clean_plate_difference = 6;
};

}  // namespace keypose::capture
