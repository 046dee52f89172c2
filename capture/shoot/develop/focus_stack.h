// One sharp photograph from several with different focus.
#pragma once

#include <vector>

#include "core/values/image.h"

namespace keypose::capture::shoot {

/// Aligns the photographs (the focus changes their scale a little) and takes each detail from the
/// one that shows it sharpest.
///
/// Each photograph is moved onto the middle one by an affine map (ECC). Of their Laplacian pyramids
/// the coefficient with the largest local energy is kept; the coarsest levels are averaged.
/// Source: Evangelidis & Psarakis, PAMI 2008 (ECC); Burt & Kolczynski, ICCV 1993 (fusion).
/// @param images  RGB, of one size, two at least
/// @throws InputError  fewer than two, different sizes, or photographs that do not show the same
/// Same bits for any thread count.
Image8 MergeFocusStack(const std::vector<Image8>& images);

}  // namespace keypose::capture::shoot
