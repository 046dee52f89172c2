// A surface moved along its normals to where the photographs agree best, as smooth as they leave
// it.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "core/options.h"
#include "core/progress.h"
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
  double cuts = 1;
  double shading = 1;
  int shading_smooth = 60;
  double outside_px = 1;
  double normal_reach = 2;
  void Describe(OptionVisitor& visit);
};

struct RefineResult {
  Mesh mesh;                ///< the surface's faces and colours, other places
  double footprint = 0;     ///< world length of a pixel, the median over the vertices that are seen
  double moved_median = 0;  ///< footprints
  double moved_95 = 0;      ///< footprints, 95 % of the vertices
  double cost_before = 0;   ///< mean of one minus the correlation between views where the surface
                            ///< was, at the finest level
  double cost_after = 0;    ///< and where it is now
  double seen = 0;          ///< share of the vertices that two views or more can compare
  double evidence = 0;      ///< share of the vertices where photographs tell one place from another
  /// mean distance between the surface's outlines and the masks'
  double outline_gap_before_px = 0;
  double outline_gap_px = 0;
  /// median relative error of brightness as light of few directions explains it
  double shading_error_before = 0;
  double shading_error_after = 0;  ///< with the normals that explain it best
  int unfolded = 0;                ///< vertices held back so that no face turns over
  int held_inside = 0;             ///< vertices held back by the masks' outlines
};

/// Coarse to fine over the views' pyramids, each level `rounds` times: the agreement of views on
/// patches pushed along the normals (CostProfiles), averaged over neighbours, gives each vertex a
/// place and how sure it is; displacements that meet these and bend the surface least are solved
/// for.
///
/// @param surface  may be open; faces counter-clockwise seen from outside
/// @param views    all with options.levels levels
/// @throws InputError  an unusable mesh, or no vertex that two views see; says so
/// Same bits for any thread count on one kind of processor.
/// Source: Vu, Labatut, Pons, Keriven, PAMI 2012 (what is minimised).
/// Departs: exhaustive search along normals (as Newcombe et al., ICCV 2011, search along rays)
/// instead of gradient descent, which needs a start within a pixel.
RefineResult RefineSurface(const Mesh& surface, const std::vector<PreparedView>& views,
                           const RefineOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
