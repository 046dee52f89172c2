// As-rigid-as-possible interpolation of the solid between two keys: for strong twists, under which
// a surface alone would collapse.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::interpolation {

struct VolumetricOptions {
  /// wanted edge length of inner tetrahedra over the surface's mean edge, > 0
  double element_size = 1;
  int max_tetrahedra = 50000;  ///< approximate: inner tetrahedra become larger where element_size
                               ///< would need more; a fine surface needs more all the same
  bool follow_turns = true;    ///< neighbouring tetrahedra turn the same way round, beyond 180
                               ///< degrees; else each takes its shortest turn
  bool keep_volume = true;     ///< each body's volume follows v0^(1-t) v1^t to 1e-8
};

/// Measurements of the solid.
struct VolumetricReport {
  int tetrahedra = 0, nodes = 0;  ///< nodes: the surface's vertices and those inside
  int bodies = 0;                 ///< separate solids
  int meshed_key = 0;             ///< 0: the first key was filled with tetrahedra, 1: the second
  int inverted = 0;  ///< tetrahedra that are inverted in the other key, after untangling; their
                     ///< stretch is interpolated linearly
  /// vertices where the filled key intersects itself: moved apart to fill it, then moved back
  int parted = 0;
  double largest_turn = 0;  ///< of any tetrahedron [rad]; beyond pi only with follow_turns
  /// largest difference of neighbours' turns beyond that of their rotations [rad]; near 0 unless
  /// the body is a ring that turned inside itself
  double largest_tear = 0;
  std::string note;  ///< why the other key had to be filled, or empty
};

/// Frames between keys V and U that deform as solid clay, not as an empty shell.
///
/// One key is filled with tetrahedra whose boundary is the surface itself. The other key's inner
/// points come from a volumetric as-rigid-as-possible fit, so both keys share one solid. Each
/// tetrahedron's map is split into turn and stretch (S^t), turns of neighbours agree beyond 180
/// degrees, and nodes are fitted with one factored Laplacian of both keys. At(0) and At(1) return
/// the keys' own bits.
///
/// The smoother surface (least bending energy) is filled, independent of the keys' order, and
/// everything is computed in that direction: swapping the keys gives frame t the bits of frame 1-t.
/// Same bits for any thread count.
/// Source: Ebner et al., E-StopMotion, section 4.2, on real tetrahedra; Alexa et al. 2000; TetGen:
/// Si 2015.
class VolumetricInterpolator {
 public:
  /// @param v, u  V x 3 with the same faces; vertices in no face move on straight lines
  /// @throws InputError  different numbers of vertices, or an open, inside-out or self-touching
  /// surface: names the first fault and the remedy
  /// @throws SolverError
  VolumetricInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces,
                         const VolumetricOptions& options = {});
  ~VolumetricInterpolator();
  VolumetricInterpolator(VolumetricInterpolator&&) noexcept;

  PointsX3 At(double t) const;
  /// Several frames with one batch of solves. V x 3 each.
  std::vector<PointsX3> At(const std::vector<double>& times) const;
  const VolumetricReport& report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::interpolation
