// Windows through the figure that all masks have filled alike, found by what the photographs show
// in them.
#pragma once

#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/segmentation/mask_holes.h"
#include "core/camera.h"
#include "core/image.h"

namespace keypose::capture {

/// Opens what shows the empty set and what other photographs see through as well. A window that all
/// masks have filled stands in their hull as a thick wall, so the hull cannot say whether a region
/// that looks like the empty set is one. So all such regions are opened at once, and each is asked
/// how much of its rays the openings of the others leave: nearly nothing in a window, which is seen
/// from both sides; of an eye's shade nearly all, as nobody looks through the head. Regions that
/// are left thick close again, until what is open agrees.
/// @param images  RGB
/// @param views   with cameras of the images' size
/// @param backdrops  of the images' size; where the figure has the empty set's own colours, too
/// @param inlier  one a view, 0 for an outlier, which is not opened; empty: all are inliers
/// @param masks   of the images' size; get the windows opened
/// @return what was opened, over the area of all masks
/// @throws InputError  the masks have no common space
/// Same bits for any thread count.
double OpenWindows(const std::vector<Image8>& images, const std::vector<View>& views,
                   const std::vector<Backdrop>& backdrops, const SpaceOptions& options,
                   const std::vector<char>& inlier, std::vector<Image8>& masks);

}  // namespace keypose::capture
