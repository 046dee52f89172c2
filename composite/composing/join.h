// How well a picture that was rendered at a filmed frame's time joins that frame.
#pragma once

#include "core/values/image.h"

namespace keypose::composite {

struct JoinFigures {
  double psnr_db = 0;         ///< in the character's box
  double edge_px = 0;         ///< mean distance of the outlines, along their normals
  double edge_share = 0;      ///< of the outline where the set differs enough to measure it
  double colour_levels = 0;   ///< mean difference of smoothed colour on the character, of 255
  int box[4] = {0, 0, 0, 0};  ///< x0, y0, x1, y1
};

/// @param rendered, filmed  RGB
/// @param coverage          1 channel, 0 to 1: of the character
/// @return all 0 when the character covers nothing
JoinFigures MeasureJoin(const Image8& rendered, const Image8& filmed, const ImageF& coverage);

/// PSNR [dB] of two pictures within pixels [x0,x1) x [y0,y1); 99 when they are equal.
double PsnrWithin(const Image8& a, const Image8& b, const int box[4]);

/// Filmed, rendered, and their difference four times enlarged around grey, side by side.
Image8 SideBySide(const Image8& filmed, const Image8& rendered);

}  // namespace keypose::composite
