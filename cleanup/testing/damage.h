// Shapes with limbs, and the ways in which meshes get broken: what the guarantee is tried on. For
// tests and measurements only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose::cleanup {

/// Closed torus round z.
/// @param n  segments round the axis @param m  segments round the tube
Mesh MakeTorus(double radius, double tube, int n, int m);
/// Closed surface of revolution round z: rings of `n` vertices at (radius, height) from the top
/// down, and a fan over each end.
Mesh MakeRevolved(const std::vector<Eigen::Vector2d>& profile, int n);
/// Closed figure with a body, a head, and limbs `limb` cells thick, blown up from cells and
/// smoothed; proportions vary with the seed.
Mesh MakeFigure(std::uint64_t seed, int limb);
/// Both meshes as one, unconnected.
Mesh Together(const Mesh& a, const Mesh& b);

/// One of the thousand: a shape by the index, broken by one to four kinds of damage with
/// deterministic choices.
struct Mutilated {
  Mesh mesh;
  std::string story;  ///< shape and damage, for messages
};
Mutilated MakeMutilated(int index);

}  // namespace keypose::cleanup
