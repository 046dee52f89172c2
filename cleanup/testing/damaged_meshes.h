// Shapes with limbs, and kinds of mesh damage, for tests of the cleanup's guarantee. For tests and
// measurements only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// A closed torus around the z axis.
/// @param n  segments around the axis
/// @param m  segments around the tube
Mesh MakeTorus(double radius, double tube, int n, int m);
/// A closed surface of revolution around z: rings of `n` vertices at (radius, height) from the top
/// down, and a fan at each end.
Mesh MakeRevolved(const std::vector<Eigen::Vector2d>& profile, int n);
/// A closed figure with a body, a head and limbs that are `limb` cells thick. It is made of cubic
/// cells and smoothed; its proportions depend on the seed.
Mesh MakeFigure(std::uint64_t seed, int limb);
/// Both meshes in one, not connected.
Mesh Together(const Mesh& a, const Mesh& b);

/// One of the thousand damaged meshes: the index chooses a shape and one to four kinds of damage.
/// Deterministic.
struct DamagedMesh {
  Mesh mesh;
  std::string description;  ///< shape and damage, for messages
};
DamagedMesh MakeDamagedMesh(int index);

}  // namespace keypose::cleanup
