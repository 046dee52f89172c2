// Tests on small pictures, in seconds, whether the photographs of a set overlap.
#pragma once

#include <vector>

#include "core/pictures/joined_images.h"
#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::capture {

/// A photograph in a size that is compared quickly with all others.
struct Preview {
  Image8 grey, mask;  ///< one channel, same size
};

/// Pairs of photographs that overlap: SIFT features inside the masks (at most 400 each), mutual
/// matches that pass the ratio test, and of these the inliers of one fundamental matrix (16 at
/// least).
/// Same result for any thread count.
/// Cost: some 50 ms per photograph and 1 ms per pair at 640 px.
std::vector<ImageTie> SharedPlaces(const std::vector<Preview>& previews,
                                   Progress* progress = nullptr);

/// The same for some pairs, by the places alone that lie at least so far apart in the two pictures.
/// @param previews  those of no pair may be empty
/// @return the pairs that overlap
std::vector<ImageTie> SharedPlaces(const std::vector<Preview>& previews,
                                   std::vector<ImageTie> pairs, double least_move_px,
                                   Progress* progress = nullptr);

}  // namespace keypose::capture
