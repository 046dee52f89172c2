// One region of an image from log odds at its pixels.
#pragma once

#include "core/values/image.h"

namespace keypose::capture {

/// Minimum-cost labelling of the pixels by a graph cut. The cost consists of the odds, and of a
/// term for each pair of differently labelled neighbours, which decreases with their colour
/// difference. The result is the region with the largest weight near the middle, with its holes
/// filled unless they are clearly background (mean odds below -sure).
/// @param image       RGB
/// @param odds        ln p(object) / p(background), one channel, same size
/// @param smoothness  cost of a border between two pixels of the same colour
/// @return 255 in the region; all zero if there is none
/// Source: Boykov & Jolly, ICCV 2001; the decreasing cost is GrabCut's (Rother et al., SIGGRAPH
/// 2004).
Image8 CutRegion(const Image8& image, const ImageF& odds, double smoothness, double sure);

/// CutRegion with all regions, not the best alone.
Image8 CutRegions(const Image8& image, const ImageF& odds, double smoothness, double sure);

/// The labelling that CutRegion begins with: all regions, holes as they are.
Image8 CutLabels(const Image8& image, const ImageF& odds, double smoothness);

/// Fills a mask's holes unless they are clearly background (mean odds below -sure).
void FillUnclearHoles(Image8& mask, const ImageF& odds, double sure);

/// The 8-connected region of a mask with the largest weight, where a pixel's weight increases
/// towards the middle.
Image8 BestRegion(const Image8& mask);

}  // namespace keypose::capture
