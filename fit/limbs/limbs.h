// The limbs of a shape: arms, ears and tails, found as ends far from the rest of the surface.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::fit {

/// A part that sticks out, from its tip to where it meets the rest.
struct Limb {
  std::vector<int> vertices;  ///< of the mesh, ascending
  Eigen::VectorXd along;      ///< by vertex of the limb: its distance from the tip [unit of points]
  double length = 0;          ///< the largest of them
};

/// The parts around the peaks of the mean geodesic distance to all of the surface. Each begins at
/// a peak and ends where the field has fallen to the saddle towards a higher peak, where the part
/// would be more than a tenth of the surface, or at a neck beyond which its width doubles. Longest
/// first.
/// Source: mean geodesic distances, Hilaga et al., SIGGRAPH 2001.
/// @throws InputError  no vertices
std::vector<Limb> FindLimbs(const PointsX3& points, const FacesX3& faces);

}  // namespace keypose::fit
