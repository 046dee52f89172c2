// Nesting: where rigid outlines go in a square so that it is filled as far as possible, a search
// over places and turns.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.h"

namespace keypose::texture {

/// Where an outline comes to lie: turned by `angle` about the origin, scaled, then moved.
struct Placement {
  double angle = 0;                                  ///< [rad]
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< [side of the square]
};

struct Nesting {
  double scale = 0;  ///< sides of the square per unit of the outlines; 0: nothing fits
  std::vector<Placement> places;
};

struct NestingOptions {
  double gap = 0;    ///< [side of the square] wanted between outlines; half of it to the border
  int margin = 0;    ///< [cells] extra width of the outlines; 1 leaves no overlaps at all
  int effort = 600;  ///< moves of the search, in sixteens; cost grows with it
  int searches = 2;  ///< independent ones, side by side; the largest result counts
  int cells = 256;   ///< of the grid along the square; places are multiples of its cell
};

/// @param outlines  simple polygons, counter-clockwise
/// @return the largest scale found, with outlines that overlap by about half a cell at most (cells
/// count by
///         their centres): SetApart moves them apart. Never mirrored. Same result for any thread
///         count.
/// Starts bottom-left (tallest first, bays filled), then grows the scale and resolves the overlaps
/// one outline at a time, where pairs that keep overlapping weigh more and more.
/// Source: Egeblad, Nielsen, Odgaard, EJOR 2007 (guided local search).
/// Departs: overlap counted on a grid, any turn of 64, place found by samples and descent.
Nesting Nested(const std::vector<UvsX2>& outlines, const NestingOptions& options);

}  // namespace keypose::texture
