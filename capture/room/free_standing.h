// Whether a figure stands free, or is part of a wall or a trunk.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct FreeStandingOptions {
  double beside = 0.06;  ///< of the picture's longer side: points so near are beside each other
  double level = 0.03;   ///< of the depth: points whose depths differ by less go on into each other
  double floor = 0.02;   ///< of the cameras' distance: points so near to the floor do not count
  int fewest = 40;       ///< pairs of points, over all views
};

/// Sparse points just outside of the masks, compared with the nearest one inside.
struct Attachment {
  int pairs = 0;     ///< of a point outside and one inside, in one view
  double share = 0;  ///< of them, those with one depth: the surface goes on beyond the outline
  /// Whether there are enough pairs, and most go on.
  bool attached = false;
};

/// Around a figure that stands free, what is seen beside its outline is farther away, but for the
/// floor at its feet. Around a relief the wall goes on at the same depth.
/// @param scene  views with cameras of the masks' size, and points with the views that see them
/// @param masks  by view
/// @param on_floor  z = 0 is the floor: points on it do not count
Attachment FindAttachment(const Scene& scene, const std::vector<Image8>& masks, bool on_floor,
                          const FreeStandingOptions& options = {});

/// The share of the masks that go on beyond three sides of their photographs or all four: what is
/// in them is no figure but its surroundings. A close-up goes beyond one or two.
double BeyondThePictures(const std::vector<Image8>& masks);

}  // namespace keypose::capture
