// The finished mesh, with measurements of it and of its repair.
#pragma once

#include <string>

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// Distance between two surfaces, over the diagonal; sampled uniformly by area.
struct SurfaceDistance {
  double mean = 0, p99 = 0, max = 0;
};

struct CleanupResult {
  Mesh mesh;             ///< closed; with colours when the input has them
  std::string strategy;  ///< as-is, R0 weld, R2 fill, R3 intersections, R4 wrap
  int holes_filled = 0;
  double largest_hole_over_diag = 0;
  int components_removed = 0;
  int supports_removed = 0;               ///< turntables, bases and cloths cut off below the figure
  double cut_below_ground_over_diag = 0;  ///< depth of the part that was cut off below the ground
  int merged_vertices = 0;
  /// intersecting pairs of faces after merging vertices and filling holes
  int self_intersections_before = 0;
  int self_intersections = 0;  ///< of the result: always 0
  int components = 0;
  int genus_before = 0;  ///< handles of the closed surface before any was removed
  int handles_cut = 0;
  /// length of the longest loop along which a handle was cut
  double largest_handle_cut_over_diag = 0;
  int handles_seen_through = 0;  ///< of the result, by the lines of sight
  int genus = 0;                 ///< of all components together
  double area = 0, volume = 0;   ///< [input units ^2, ^3]
  double min_angle_deg = 0;
  double mean_min_angle_deg = 0;
  SurfaceDistance to_input;    ///< from the result to the input
  SurfaceDistance from_input;  ///< from the kept part of the input to the result
  double undamaged_share = 1;  ///< share of the kept input's area that is farther from all repairs
                               ///< than an edge length of the result
  SurfaceDistance undamaged_to_input,
      undamaged_from_input;  ///< the same distances on that part: the effect of remeshing
};

}  // namespace keypose::cleanup
