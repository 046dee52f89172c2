// As-rigid-as-possible interpolation between two keys of one connectivity.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/surface/key_constraints.h"
#include "interpolate/turns/turns.h"

namespace keypose::interpolation {

struct ArapOptions {
  /// sum of both directions' energies; else the first key's only, as in the paper
  bool symmetric = true;
  Stretch stretch = Stretch::kBalanced;  ///< how a face's stretch grows with t
  bool follow_turns = true;  ///< neighbours turn the same way round (see turns.h); else every face
                             ///< takes its shortest turn
  bool correct_volume = true;  ///< closed parts whose volumes have one sign follow v0^(1-t) v1^t
  std::vector<TurnOverride> turn_overrides = {};
  /// A limb that turns by half a turn in one step takes the direction in which it intersects itself
  /// less half-way.
  bool choose_half_turns = true;
  Constraints constraints = {};
};

/// The paper's own energy, reduced to V unknowns: the same frames as PaperInterpolator.
ArapOptions PaperOptions();

struct ArapReport {
  int degenerate_faces = 0;
  TurnReport turns;
  /// limbs of half a turn that take the other direction than the first one found
  std::vector<TurnOverride> half_turns;
  int closed_parts = 0,
      corrected_parts = 0;  ///< connected parts of the mesh, and those whose volume is corrected
  int riding_parts = 0;     ///< loose parts that keep their place on the body (see loose_parts.h)
  std::vector<std::string> dropped_constraints;  ///< rows that are implied by others
};

/// Measurements of one frame.
struct FrameFacts {
  double volume_move = 0;  ///< largest displacement of a vertex by the volume correction
  int floor_vertices = 0;  ///< vertices held at the floor
};

/// Frames between keys V and U. Each triangle's map is split into turn and stretch, both are
/// interpolated, and vertices are fitted to the wanted edges.
///
/// Energy, matrix and turns are symmetric: swapping the keys gives the same frames at 1 - t, bit
/// for bit (the keys are put in a fixed order first). At(0) and At(1) have the keys' own bits,
/// unless a constraint moves them. Each connected part keeps its centroid on the path that follows
/// from the body's turn, unless constraints hold it.
/// Cost: two factorisations of V x V with one symbolic analysis, one solve with three right-hand
/// sides per frame, all frames of a call in one batch.
/// Same bits for any thread count.
/// Source: Ebner et al., E-StopMotion, section 4.2; Alexa et al. 2000; Baxter et al. 2008. Reduced
/// from (V+F) to V unknowns: elimination of the free fourth vertices gives exactly the cotangent
/// Laplacian.
/// Departs: symmetric energy, turns beyond 180 degrees, balanced stretch, volume that follows the
/// keys.
class ArapInterpolator {
 public:
  /// @throws InputError   different numbers of vertices, unusable mesh, bad constraint or override
  /// @throws SolverError  the Laplacian cannot be factored
  ArapInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces,
                   const ArapOptions& options = {});
  ~ArapInterpolator();
  ArapInterpolator(ArapInterpolator&&) noexcept;

  PointsX3 At(double t) const;
  /// Several frames with one batch of solves. Memory grows with their number (about 0.1 kB per
  /// vertex and frame).
  std::vector<PointsX3> At(const std::vector<double>& times,
                           std::vector<FrameFacts>* facts = nullptr) const;

  const ArapReport& report() const;
  const PoissonSystem& system() const;

  int degenerate_faces() const { return report().degenerate_faces; }
  double largest_turn() const {
    return report().turns.largest_turn;
  }  ///< of any face relative to the body [rad]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

PointsX3 InterpolateLinearly(const PointsX3& v, const PointsX3& u, double t);

/// Fills `growth` of each face: log of the linear scale of the region around it, smoothed over the
/// system's screening length.
void SetGrowth(const PoissonSystem& system, SegmentMaps& maps);

/// Path of each connected part's centroid between two keys: the body's centroid moves on a straight
/// line, the parts' offsets from it turn with the body.
class CentroidPaths {
 public:
  CentroidPaths(const PointsX3& v, const PointsX3& u, const std::vector<int>& parts, int part_count,
                const Eigen::Vector3d& body_turn);
  Eigen::Vector3d At(int part, double t) const;

 private:
  PointsX3 start_, end_;  // offsets from the body's centroid, part by part; end_ turned back
  Eigen::Vector3d body_start_, body_end_, body_turn_;
};

}  // namespace keypose::interpolation
