// What a person said the figure is, in photographs while `capture` masks them.
#pragma once

#include <string>
#include <vector>

#include "capture/photograph_import.h"
#include "capture/room/stroke_masks.h"

namespace keypose::capture {

/// The strokes of each photograph, in pixels of its working image. Warns of those that are not
/// used: of no photograph, or where the photograph has a mask of the user's.
/// @param figure  as ParseFigureStrokes reads it
/// @pre import.small has the working images
std::vector<ViewStrokes> StrokesIn(StageContext& stage, const PhotographImport& import,
                                   const std::string& figure);

/// The mask of a photograph with strokes: of all regions that the set's segmentation found in it,
/// those under the strokes; where it found none there, or one with what is not the figure, the
/// photograph is segmented by its own colours, from the strokes outwards.
/// @param name     of the photograph, for a warning where strokes that say only what is not the
/// figure leave nothing
/// @param regions  all of the set's segmentation
Image8 SaidMask(StageContext& stage, const std::string& name, const Image8& small,
                const Image8& regions, const ViewStrokes& strokes);

}  // namespace keypose::capture
