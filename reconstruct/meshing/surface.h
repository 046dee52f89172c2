// From an oriented, coloured point cloud to a coloured surface.
#pragma once

#include <string>

#include "core/values/mesh.h"
#include "core/values/options.h"
#include "core/values/progress.h"
#include "reconstruct/meshing/points.h"
#include "reconstruct/meshing/poisson_surface.h"
#include "reconstruct/meshing/surface_windows.h"
#include "reconstruct/meshing/trim.h"

namespace keypose::reconstruct {

/// Options of the mesh stage.
struct MeshOptions {
  /// octree levels; 0: chosen from the sampling, ceil(log2(diagonal / (2 spacing)))
  int depth = 0;
  int max_depth = 8;   ///< upper limit for depth 0
  double merge = 0.5;  ///< edge of the cells in which points are merged, in finest octree cells;
                       ///< the surface has no finer detail; 0: no merging
  PoissonOptions poisson;
  PointFilterOptions filter;
  TrimOptions trim;

  void Describe(OptionVisitor& visit);
};

struct SurfaceResult {
  Mesh mesh;            ///< with colours where the cloud has them; open where there was no data
  int depth = 0;        ///< octree levels used
  FilteredPoints used;  ///< the points that were used, and numbers of removed ones
  int poisson_faces = 0;
  int trimmed_faces = 0;
  int removed_components = 0;
  int kept_closures = 0;
  int views_with_closed_window = 0;  ///< of the first fit, see BlockedLines
  int window_points = 0;             ///< points of windows' walls that were added for a second fit
};

/// Octree levels that resolve samples at a distance of `spacing` in a cloud of `diagonal`, in [4,
/// max_depth].
int DepthForSampling(double diagonal, double spacing, int max_depth);

/// Filters the points, solves screened Poisson, removes the surface where there is no data, and
/// colours the rest.
///
/// A window that photographs see through, but that the surface closes, is opened: its walls, from
/// the outlines, are added to the points, and the surface is fitted again.
/// @param what     names the cloud in messages
/// @param windows  without lines, windows are ignored
/// @throws InputError   see FilterPoints
/// @throws SolverError  no surface near the points
/// Same bits for any thread count.
SurfaceResult ReconstructSurface(PointCloud cloud, const MeshOptions& options,
                                 const std::string& what, Progress* progress,
                                 const WindowEvidence& windows = {});

}  // namespace keypose::reconstruct
