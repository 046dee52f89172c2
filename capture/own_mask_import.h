// A person's masks during import: read as other programs write them, and brought over their
// photographs.
#pragma once

#include "capture/photograph_import.h"

namespace keypose::capture {

/// Looks at all masks that the person gives and notes in `mask_ways` how each is to be taken. Warns
/// of what it finds out by itself: masks that are white round the figure, lie as the photograph is
/// stored, or are smaller. Masks without a figure are taken out of `user_masks`, unless all are so.
/// @throws InputError  masks that cannot be understood, each by name
void FindWaysOfMasks(StageContext& stage, PhotographImport* import);

/// The mask as it will be written: 255 where the figure is, else 0.
/// @throws InputError  another shape than the photograph; levels that cannot be understood
Image8 LoadOwnMask(const PhotographImport& import, std::size_t i);

}  // namespace keypose::capture
