// Small displacements of the photographs that make them agree on the surface they share.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

/// A smooth displacement of one photograph: bilinear between the nodes of a lattice; nothing
/// without nodes.
struct Warp {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< pixel of node (0, 0)
  double spacing = 1;                                ///< [px] between nodes
  int wide = 0, high = 0;                            ///< nodes
  std::vector<Eigen::Vector2d> nodes;                ///< [px]; row by row

  /// Where the photograph shows what its camera projects to `pixel`.
  Eigen::Vector2d Moved(const Eigen::Vector2d& pixel) const;
};

struct AlignOptions {
  int samples = 60000;  ///< points of the surface at which photographs are compared
  int nodes = 14;       ///< of a lattice along the longer side of what the photograph shows
  /// of the lattice, in parts of what the photographs tell of a node on average
  double smoothness = 0.5;
  double stiffness = 0.02;  ///< pull towards no displacement, in the same parts
  double most_px = 12;      ///< no node moves further than this
};

/// One warp a view.
///
/// Photographs are compared in what they show finer than 8 of their present pixels (square root of
/// linear light): exposure, and light that changes slowly along the surface, say nothing. Coarse to
/// fine, in turns: the robust mean of all views at each point; then each view's lattice takes a
/// Gauss-Newton step towards it. Where a photograph shows no texture its neighbourhood decides. A
/// common drift of all photographs along the surface is not seen; the pull to no displacement keeps
/// it small.
///
/// @param used  one a view: 0 leaves it out, its warp is empty and nobody is aligned to it
/// Deterministic; the same bits for any thread count.
/// Source: Zhou, Koltun, SIGGRAPH 2014 (lattices, alternation).
/// Departs: detail instead of grey values, samples of the surface instead of its vertices, a robust
/// mean; cameras stay.
std::vector<Warp> AlignPhotographs(const Mesh& mesh, const std::vector<BakeView>& views,
                                   const std::vector<char>& used, const AlignOptions& options = {});

}  // namespace keypose::texture
