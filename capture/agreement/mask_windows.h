// Finds windows through the figure that all masks have filled.
#pragma once

#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/segmentation/mask_holes.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

/// Opens regions that show the empty set and through which other photographs see as well. A window
/// that all masks have filled is a thick wall in their hull, so the hull does not decide whether a
/// region that looks like the empty set is a window. So all such regions are opened at once, and
/// for each the remaining thickness of the hull along its rays is measured. It is nearly zero in a
/// window, which is seen from both sides. It stays nearly the same in an eye's shade, since no view
/// sees through the head. Regions that stay thick are closed again, until the open ones are
/// consistent.
/// @param images  RGB
/// @param views   with cameras of the images' size
/// @param backdrops  of the images' size; also where the figure has the empty set's colours
/// @param inlier  one per view, 0 for an outlier, which is not opened; empty: all are inliers
/// @param masks   of the images' size; windows are removed from them
/// @return opened area over the area of all masks
/// @throws InputError  the masks have no common space
/// Same bits for any thread count.
double OpenWindows(const std::vector<Image8>& images, const std::vector<View>& views,
                   const std::vector<Backdrop>& backdrops, const SpaceOptions& options,
                   const std::vector<char>& inlier, std::vector<Image8>& masks);

}  // namespace keypose::capture
