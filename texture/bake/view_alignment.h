// Small displacements of the photographs so that they agree on the surface that they share.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/mesh.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

/// A smooth displacement of one photograph: bilinear between the nodes of a lattice; zero without
/// nodes.
struct Warp {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< pixel of node (0, 0)
  double spacing = 1;                                ///< [px] between nodes
  int wide = 0, high = 0;                            ///< nodes
  std::vector<Eigen::Vector2d> nodes;                ///< [px]; row by row

  /// Position in the photograph of a point that the camera projects to `pixel`.
  Eigen::Vector2d Moved(const Eigen::Vector2d& pixel) const;
};

struct AlignOptions {
  int samples = 60000;  ///< points of the surface at which photographs are compared
  int nodes = 14;       ///< number of nodes along the longer side of the photograph's used part
};

/// One warp per view.
///
/// Photographs are compared by their detail finer than 8 of their current pixels (square root of
/// linear light), so that exposure, and light that changes slowly along the surface, have no
/// effect. From coarse to fine, two steps alternate: the robust mean of all views at each point; a
/// Gauss-Newton step of each view's lattice towards it. Where a photograph has no texture its
/// neighbourhood decides. A common drift of all photographs along the surface is not observable;
/// the prior of zero displacement keeps it small.
///
/// @param used  one per view: with 0 it is left out, its warp is empty, and no view is aligned to
/// it
/// Deterministic; the same bits for any thread count.
/// Source: Zhou, Koltun, SIGGRAPH 2014 (lattices, alternation).
/// Departs: detail instead of grey values, samples of the surface instead of its vertices, a robust
/// mean; cameras stay fixed.
std::vector<Warp> AlignPhotographs(const Mesh& mesh, const std::vector<BakeView>& views,
                                   const std::vector<char>& used, const AlignOptions& options = {});

}  // namespace keypose::texture
