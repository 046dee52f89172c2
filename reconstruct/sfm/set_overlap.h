// Uses matches before cameras are estimated: whether a set can form one model, and which
// photographs are upside down.
#pragma once

#include <vector>

#include "reconstruct/sfm/evidence_check.h"
#include "reconstruct/sfm/matched_features.h"

namespace keypose::reconstruct {

/// Stops if photographs that match some others form many small groups without common features: they
/// were shot too far apart. A figure without texture, whose photographs have no matches, is left to
/// the outlines.
/// @throws InputError  names the groups and what to shoot
void RequireOverlap(StageContext& stage, const ImageSet& set, const MatchedFeatures& matched);

/// Finds the photographs that are upside down relative to the others, by matches, else by outlines;
/// notes them.
/// @return by image, 1 or 0
std::vector<char> FindUpsideDown(StageContext& stage, const ImageSet& set,
                                 const EvidenceCheck& check, const MatchedFeatures& matched);

}  // namespace keypose::reconstruct
