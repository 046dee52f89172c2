// Moves a surface along its normals to the best photometric consistency, with smoothness where the
// photographs do not determine it.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "core/values/options.h"
#include "core/values/progress.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct RefineOptions {
  int max_size = 1600;
  int levels = 2;
  int rounds = 3;
  double anchor = 0.01;
  double membrane = 0.02;
  double bending = 200;
  int aggregate = 2;
  double outlines = 3;
  double violations = 1;
  double shading = 1;
  int shading_smooth = 60;
  double outside_px = 1;
  double normal_reach = 2;
  void Describe(OptionVisitor& visit);
};

struct RefineResult {
  Mesh mesh;                ///< the surface's faces and colours, at new positions
  double footprint = 0;     ///< size of a pixel in world units, the median over the seen vertices
  double moved_median = 0;  ///< footprints
  double moved_95 = 0;      ///< footprints, 95th percentile over the vertices
  double cost_before = 0;   ///< mean of one minus the correlation between views for the initial
                            ///< surface, at the finest level
  double cost_after = 0;    ///< and for the final surface
  double seen = 0;          ///< share of the vertices that at least two views see
  double evidence = 0;      ///< share of the vertices whose position the photographs determine
  /// mean distance between the surface's outlines and the masks'
  double outline_gap_before_px = 0;
  double outline_gap_px = 0;
  /// median relative error of brightness under the fitted light
  double shading_error_before = 0;
  double shading_error_after = 0;  ///< with the best-fitting normals
  int unfolded = 0;     ///< vertices whose displacement was reduced so that no face turns over
  int held_inside = 0;  ///< vertices whose displacement was limited by the masks' outlines
};

/// Coarse to fine over the views' pyramids, `rounds` times at each level. The photometric
/// consistency of patches moved along the normals (CostProfiles), averaged over neighbours, gives
/// each vertex a target and a weight. Then the displacements are solved for that fit the targets
/// with the least bending.
///
/// @param surface  may be open; faces counter-clockwise seen from outside
/// @param views    all with options.levels levels
/// @throws InputError  an unusable mesh, or no vertex that two views see
/// Same bits for any thread count on one kind of processor.
/// Source: Vu, Labatut, Pons, Keriven, PAMI 2012 (the energy).
/// Departs: exhaustive search along normals (as Newcombe et al., ICCV 2011, search along rays)
/// instead of gradient descent, which needs a start within a pixel.
RefineResult RefineSurface(const Mesh& surface, const std::vector<PreparedView>& views,
                           const RefineOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
