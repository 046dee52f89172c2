// Windows that the photographs see through and a fitted surface closes.
#pragma once

#include <functional>
#include <vector>

#include "core/sight_lines.h"
#include "reconstruct/meshing/points.h"

namespace keypose::reconstruct {

/// How far outside of the outlines a place lies [px], positive outside: see Silhouettes::Outside.
using OutsideField = std::function<double(const Eigen::Vector3d&)>;

/// What tells windows.
struct WindowEvidence {
  std::vector<SightLine> lines;  ///< through the holes of the masks
  std::function<OutsideField()>
      read_outside;  ///< called once, and only where a window is closed, as it reads all masks
};

/// Views that a surface must block, all of one hole's lines in each, before it counts as closing a
/// window.
constexpr int kViewsOfAWindow = 3;

/// Adds the walls of the windows that `surface` closes to the points that it was fitted to, as sure
/// points of the outlines' hull, and takes out points that lie in the open. Stereo hardly sees a
/// window's walls, as they are nearly edge on in all photographs that look through it, so the
/// surface webs it over.
///
/// A window is what lies inside of the surface, outside of the outlines by more than 1.5 px, and
/// together with the blocked lines' way through the surface.
/// @param surface  closed, as Poisson makes it
/// @param blocked  lines that meet the surface and should not
/// @param cell     edge of the finest octree cell; walls get about a point in each
/// @return walls added; with 0 nothing is changed
/// Same bits for any thread count.
int AddWindowWalls(const Mesh& surface, const std::vector<SightLine>& blocked,
                   const OutsideField& outside, double cell, FilteredPoints* points);

/// The lines of those holes that the surface blocks altogether; nothing when these are in fewer
/// than kViewsOfAWindow views.
std::vector<SightLine> BlockedLines(const Mesh& surface, const std::vector<SightLine>& lines);

}  // namespace keypose::reconstruct
