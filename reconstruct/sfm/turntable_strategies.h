// The strategies of sfm that believe in a turntable: a ring model from matches, the same in an
// order found, and outlines alone.
#pragma once

#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// Asks these strategies where `best`, which was found before, is in doubt or leaves photographs
/// out. Photographs that are upside down are turned over for them, and their cameras turned back.
/// Where no photograph tells the focal length, several are tried.
/// @return what the evidence prefers, `best` or a result of theirs
StrategyResult PlaceByTurntable(const StrategyContext& context, const SfmFiles& files,
                                const MatchedFeatures& matched, StrategyResult best);

}  // namespace keypose::reconstruct
