// One region of an image from odds at its pixels.
#pragma once

#include "core/image.h"

namespace keypose::capture {

/// Least cost labelling of the pixels by a graph cut: the odds, and a cost for each pair of unlike
/// neighbours that falls with their colour difference; then the region that weighs most about the
/// middle, without its holes, unless they are plainly background (odds below -sure in the mean).
/// @param image       RGB
/// @param odds        ln p(object) / p(background), one channel, same size
/// @param smoothness  cost of a border between two pixels of one colour
/// @return 255 in the region; all zero where there is none
/// Source: Boykov & Jolly, ICCV 2001; the falling cost is GrabCut's (Rother et al., SIGGRAPH 2004).
Image8 CutRegion(const Image8& image, const ImageF& odds, double smoothness, double sure);

/// Of the regions (8-connected) of a mask, the one that weighs most, where pixels count more the
/// nearer they are to the middle.
Image8 BestRegion(const Image8& mask);

}  // namespace keypose::capture
