// Nesting: searches places and rotations of rigid outlines in a square so that they cover as much
// of it as possible.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::texture {

/// Pose of an outline: rotated by `angle` about the origin, scaled, then moved.
struct Placement {
  double angle = 0;                                  ///< [rad]
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< [side of the square]
};

struct Nesting {
  double scale = 0;  ///< sides of the square per unit of the outlines; 0: nothing fits
  std::vector<Placement> places;
};

struct NestingOptions {
  double gap = 0;    ///< [side of the square] between outlines; half of it to the border
  int margin = 0;    ///< [cells] extra width of the outlines; 1 excludes all overlaps
  int effort = 600;  ///< moves of the search, in units of 16; cost grows with it
  int searches = 2;  ///< independent ones, in parallel; the largest result is used
  int cells = 256;   ///< of the grid along the square; places are multiples of its cell
};

/// @param outlines  simple polygons, counter-clockwise
/// @return the largest scale found, with outlines that overlap by about half a cell at most (a cell
/// is covered if its centre is); SetApart separates them. Never mirrored.
/// Same result for any thread count.
/// Starts bottom-left (tallest first, bays filled). Then it increases the scale and resolves the
/// overlaps one outline at a time; the weights of pairs that keep overlapping increase.
/// Source: Egeblad, Nielsen, Odgaard, EJOR 2007 (guided local search).
/// Departs: overlap counted on a grid, 64 rotations, places found by samples and descent.
Nesting Nested(const std::vector<UvsX2>& outlines, const NestingOptions& options);

}  // namespace keypose::texture
