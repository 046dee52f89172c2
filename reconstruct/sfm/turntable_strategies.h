// The strategies of sfm that assume a turntable: a ring model from matches, the same with an
// estimated order of the photographs, and outlines alone.
#pragma once

#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// Tries these strategies if `best`, which was found before, is doubtful or lacks photographs.
/// Photographs that are upside down are rotated for them, and their cameras rotated back. If no
/// photograph has a focal length, several are tried.
/// Photographs of several sizes are not of one turntable: nothing is tried.
/// @return the result with the best evidence, `best` or a result of these strategies
/// @throws InputError  several sizes, and options.method asks for such a strategy
StrategyResult PlaceByTurntable(const StrategyContext& context, const SfmFiles& files,
                                const MatchedFeatures& matched, StrategyResult best);

}  // namespace keypose::reconstruct
