// How well a registered mesh lies on its target.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::registration {

/// Distances are over the target's bounding diagonal.
struct RegistrationQuality {
  int flipped = 0;          ///< faces whose normal points away (dot < 0) from the normal of the face with the nearest centre on the target
  int degenerate = 0;       ///< faces that shrank below 1 % of their area in the source
  double surface_rms = 0;   ///< root mean square of exact distances of area samples, both ways together
  double surface_mean = 0;  ///< mean of the two ways' means
  double hausdorff_to_target = 0, hausdorff_from_target = 0;  ///< largest distance of samples and vertices
};

/// @throws InputError  unusable mesh
/// Deterministic; 20,000 samples a way and all vertices.
RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered, const Mesh& target);

}  // namespace keypose::registration
