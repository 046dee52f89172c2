// The ground of a levelled scene, by the masks of its photographs.
#pragma once

#include <optional>

#include "core/ground_contact.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// The height at which the outlines end. Sparse points do not tell it: features are rare at the
/// feet.
/// @param level  views and points, z up
/// @return nothing without masks, or where the photographs contradict each other by more than 2 %
/// of the height
std::optional<GroundContact> GroundOf(const ImageSet& set, const Scene& level);

}  // namespace keypose::reconstruct
