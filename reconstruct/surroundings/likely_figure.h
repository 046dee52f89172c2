// Where in a photograph the figure is likely, before anything is known in space.
#pragma once

#include <Eigen/Core>

#include "core/values/image.h"
#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

/// Distances of features to a mask [px of the photograph]; 0 inside. Very large everywhere where
/// the mask is empty.
/// @param width  of the photograph
/// @param mask   at any size
Eigen::VectorXf DistanceToMask(const Features& features, int width, const Image8& mask);

/// How likely each feature of a photograph is on the figure, in [0, 1]: less away from the
/// picture's middle, at which people aim, and less away from the mask if there is one. Masks in a
/// room are often wrong: outside of them a quarter is left nearby.
/// @param mask  at any size; empty, or without any pixel above 127, where nothing is known
Eigen::VectorXf LikelyOnFigure(const Features& features, int width, int height, const Image8& mask);

}  // namespace keypose::reconstruct
