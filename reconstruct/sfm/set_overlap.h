// What matches of neighbours tell of a set before any camera is sought: whether it can join at all,
// and which photographs are upside down.
#pragma once

#include <vector>

#include "reconstruct/sfm/evidence_check.h"
#include "reconstruct/sfm/matched_features.h"

namespace keypose::reconstruct {

/// Stops where photographs that do match some others still fall into many small groups which share
/// nothing: they were shot too far apart. A figure without texture, whose photographs match
/// nothing, is left to the outlines.
/// @throws InputError  names the groups and says what to shoot
void RequireOverlap(StageContext& stage, const ImageSet& set, const MatchedFeatures& matched);

/// The photographs that are upside down beside the others, by matches, else by outlines; warns of
/// them.
/// @return by image, 1 or 0
std::vector<char> FindUpsideDown(StageContext& stage, const ImageSet& set,
                                 const EvidenceJudge& judge, const MatchedFeatures& matched);

}  // namespace keypose::reconstruct
