// What the report's own measurements say: the textured mesh compared with the photographs.
#pragma once

#include <vector>

#include "report/evidence/contents.h"
#include "report/verdicts/finding.h"

namespace keypose::report {

inline constexpr const char* kOwnMasks =
    "paint better ones in the studio, or put them into a folder masks beside the photographs";
inline constexpr const char* kMorePhotographs =
    "add photographs of this pose from the sides between, or scan it all round (method: scan)";

/// @param fitted  the template was bent into the pose's few photographs
void FindInEvidence(const PosePart& pose, bool fitted, std::vector<Finding>& out);

}  // namespace keypose::report
