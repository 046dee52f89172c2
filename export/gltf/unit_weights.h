// Weights of morph targets within the range of sliders.
#pragma once

#include "export/gltf/weighted_shapes.h"

namespace keypose::exporting {

/// The same pictures with all weights in [0, 1], since sliders of Blender and Unity end there. The
/// base is then the first picture, with weights 0, if no target gets larger than `largest_target`
/// by that; else it is a corner of the box of weights, a shape of no picture.
///
/// @return whether the base is the first picture
bool MakeUnitWeights(MorphBasis& basis, double largest_target);

}  // namespace keypose::exporting
