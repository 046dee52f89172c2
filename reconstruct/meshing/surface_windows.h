// Windows that the photographs see through and that a fitted surface closes.
#pragma once

#include <functional>
#include <vector>

#include "core/pictures/sight_lines.h"
#include "reconstruct/meshing/points.h"

namespace keypose::reconstruct {

/// Distance of a point outside of the outlines [px], positive outside: see Silhouettes::Outside.
using OutsideField = std::function<double(const Eigen::Vector3d&)>;

/// Data for finding windows.
struct WindowEvidence {
  std::vector<SightLine> lines;  ///< through the holes of the masks
  std::function<OutsideField()>
      read_outside;  ///< called at most once, and only if a window is closed, as it reads all masks
};

/// A surface closes a window when it blocks all lines of one mask hole in at least this many views.
constexpr int kViewsOfAWindow = 3;

/// Adds the walls of the windows that `surface` closes to the points that it was fitted to, as
/// confident points of the visual hull, and removes points inside the windows. Stereo hardly
/// reconstructs a window's walls: they are nearly edge-on in all photographs that see through it,
/// so the surface covers it.
///
/// A window is the region inside of the surface and outside of the outlines by more than 1.5 px
/// that is connected to the blocked lines' path through the surface.
/// @param surface  closed, as Poisson makes it
/// @param blocked  lines that meet the surface and should not
/// @param cell     edge of the finest octree cell; walls get about one point per cell
/// @return number of wall points added; with 0 nothing is changed
/// Same bits for any thread count.
int AddWindowWalls(const Mesh& surface, const std::vector<SightLine>& blocked,
                   const OutsideField& outside, double cell, FilteredPoints* points);

/// The lines of those holes that the surface blocks completely; nothing when these are in fewer
/// than kViewsOfAWindow views.
std::vector<SightLine> BlockedLines(const Mesh& surface, const std::vector<SightLine>& lines);

}  // namespace keypose::reconstruct
