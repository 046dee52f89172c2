// Opens mask holes at full resolution: narrow openings through which a photograph shows the empty
// set.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "capture/segmentation/empty_set.h"
#include "core/values/image.h"

namespace keypose::capture {

/// Data for detecting the holes in an image's figure. All at working size.
struct Backdrop {
  Image8 empty;                ///< the empty set in CIE Lab; without pixels if unknown
  std::array<int, 3> usual{};  ///< difference of most of the background from it, channel by channel
  Image8 thickness;  ///< length of each pixel's ray inside the hull, see ThicknessOfHull; without
                     ///< pixels: unknown
};

/// The background behind the figure in the images of a set.
struct Backdrops {
  std::vector<Backdrop> of;
  double alike = 0;  ///< share of the figure that looks like the empty set, lit or in shadow

  /// Whether the figure itself has the empty set's colours (bone in the dark in front of a black
  /// cloth, a white chin in front of white paper).
  bool Confusing() const { return alike > EmptySetTuning::kManyAlike; }
};

/// The empty set behind each image of a set.
/// @param lab             CIE Lab at working size
/// @param trimaps         of the same size
/// @param largest_misfit  see MaskOptions
Backdrops BackdropsOf(const std::vector<Image8>& lab, const std::vector<Image8>& trimaps,
                      const std::vector<Take>& takes, double largest_misfit);

/// Pixels of one region, y * width + x.
using Region = std::vector<std::int32_t>;

/// The regions of a mask that show the empty set, lit or in the figure's shadow, with a sharp edge
/// to the figure. The thickness of the hull is not used.
/// @param image    RGB
/// @param mask     of the same size, 255 or 0
/// @param loosely  allows larger differences: below a figure that never moves away, the empty set
/// is only interpolated from its surroundings
std::vector<Region> FindMaskHoles(const Image8& image, const Backdrop& backdrop, const Image8& mask,
                                  bool loosely);

/// Removes from a mask the regions that show the empty set, lit or in the figure's shadow: the
/// inner ends of notches and small holes, which a smooth border at working size closes. Parts of
/// the figure with the backdrop's colours are kept as far as possible: a hole has a sharp edge to
/// the figure all round, and where a photograph sees past the figure the hull is thin.
/// @param image  RGB
/// @param mask   of the same size, 255 or 0
void OpenMaskHoles(const Image8& image, const Backdrop& backdrop, Image8& mask);

}  // namespace keypose::capture
