// Mask holes: narrow openings through which a photograph shows the empty set, opened at full
// resolution.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "capture/segmentation/empty_set.h"
#include "core/image.h"

namespace keypose::capture {

/// What tells the holes in an image's figure from the figure. All at working size.
struct Backdrop {
  Image8 empty;                ///< the empty set in CIE Lab; without pixels where it tells nothing
  std::array<int, 3> usual{};  ///< how far, channel by channel, most of the background is from it
  Image8 thickness;  ///< how much of each pixel's ray lies in the hull, see ThicknessOfHull;
                     ///< without pixels: not known
};

/// What the images of a set show behind the figure.
struct Backdrops {
  std::vector<Backdrop> of;
  double alike = 0;  ///< share of the figure that looks like the empty set, in light or in shade

  /// Whether the figure itself has the empty set's colours (bone in the dark before a black cloth,
  /// a white chin before white paper).
  bool Confusing() const { return alike > kManyAlike; }
};

/// The empty set behind each image of a set.
/// @param lab             CIE Lab at working size
/// @param trimaps         of the same size
/// @param largest_misfit  see MaskOptions
Backdrops BackdropsOf(const std::vector<Image8>& lab, const std::vector<Image8>& trimaps,
                      const std::vector<Take>& takes, double largest_misfit);

/// Pixels of one region, y * width + x.
using Region = std::vector<std::int32_t>;

/// The regions of a mask that show the empty set, in light or in the figure's shade, and that the
/// figure is sharply set off from; how thick the hull is there is not asked.
/// @param image    RGB
/// @param mask     of the same size, 255 or 0
/// @param loosely  allows more difference: below a figure that always stands there the empty set is
/// only guessed from its surroundings
std::vector<Region> FindMaskHoles(const Image8& image, const Backdrop& backdrop, const Image8& mask,
                                  bool loosely);

/// Takes out of a mask what shows the empty set, in light or in the figure's shade: the inner ends
/// of notches and small holes, which a smooth border at working size closes. What has the
/// backdrop's colours but is the figure's stays, as far as that can be told: the figure is set off
/// sharply from a hole all round, and where one sees past the figure the hull is thin.
/// @param image  RGB
/// @param mask   of the same size, 255 or 0
void OpenMaskHoles(const Image8& image, const Backdrop& backdrop, Image8& mask);

}  // namespace keypose::capture
