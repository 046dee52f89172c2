// The ground of a levelled scene, from the masks of its photographs.
#pragma once

#include <optional>

#include "core/pictures/ground_contact.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// The height at which the outlines end. Sparse points do not determine it: there are few features
/// at the feet.
/// @param level  views and points, z up
/// @return nothing without masks, or where the photographs' heights differ by more than 2 % of the
/// figure's height
std::optional<GroundContact> GroundOf(const ImageSet& set, const Scene& level);

}  // namespace keypose::reconstruct
