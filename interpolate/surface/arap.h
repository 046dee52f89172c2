// As-rigid-as-possible interpolation between two keys of one connectivity.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/surface/constraints.h"
#include "interpolate/turns/turns.h"

namespace keypose::interpolation {

struct ArapOptions {
  bool symmetric = true;  ///< energies of both directions together; else from the first key only,
                          ///< as in the paper
  Stretch stretch = Stretch::kBalanced;  ///< how a face's stretch grows with t
  bool follow_turns = true;  ///< neighbours turn the same way round (see turns.h); else every face
                             ///< takes its shortest turn
  bool correct_volume = true;  ///< closed parts whose volumes have one sign follow v0^(1-t) v1^t
  std::vector<TurnOverride> turn_overrides = {};
  /// A limb that turns by half a turn in one step goes the way round that passes through itself
  /// less at mid-way.
  bool choose_half_turns = true;
  Constraints constraints = {};
};

/// The paper's own energy, reduced to V unknowns: the same frames as PaperInterpolator.
ArapOptions PaperOptions();

struct ArapReport {
  int degenerate_faces = 0;
  TurnReport turns;
  /// limbs of half a turn that go the other way round than was found first
  std::vector<TurnOverride> half_turns;
  int closed_parts = 0,
      corrected_parts = 0;  ///< connected parts of the mesh, and those whose volume is corrected
  int riding_parts = 0;     ///< loose parts that keep their place on the body (see loose_parts.h)
  std::vector<std::string> dropped_constraints;  ///< rows that follow from others
};

/// What it took to make one frame.
struct FrameFacts {
  double volume_move = 0;  ///< no vertex is moved further by the volume correction
  int floor_vertices = 0;  ///< held at the floor
};

/// Frames between keys V and U: each triangle's map is split into turn and stretch, both go from
/// nothing to their whole, and vertices are fitted to the wanted edges.
///
/// Energy, matrix and turns are symmetric: swapping the keys gives the same frames at 1 - t, to the
/// last bits (the keys are put in a fixed order first). At(0) and At(1) have the keys' own bits,
/// unless a constraint moves them. Each connected part keeps its centroid on the path that the
/// body's turn gives it, unless constraints hold it.
/// Cost: two factorisations of V x V on one analysis, one solve with three right-hand sides a
/// frame, all frames of a call in one batch.
/// Same bits for any thread count.
/// Source: Ebner et al., E-StopMotion, section 4.2; Alexa et al. 2000; Baxter et al. 2008. Reduced
/// from (V+F) to V unknowns: the free fourth vertices leave exactly the cotangent Laplacian.
/// Departs: symmetric energy, turns beyond 180 degrees, balanced stretch, volume that follows the
/// keys.
class ArapInterpolator {
 public:
  /// @throws InputError   other numbers of vertices, unusable mesh, bad constraint or override
  /// @throws SolverError  the Laplacian cannot be factored
  ArapInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces,
                   const ArapOptions& options = {});
  ~ArapInterpolator();
  ArapInterpolator(ArapInterpolator&&) noexcept;

  PointsX3 At(double t) const;
  /// Several frames with one batch of solves; memory grows with their number (about 0.1 kB a vertex
  /// and frame).
  std::vector<PointsX3> At(const std::vector<double>& times,
                           std::vector<FrameFacts>* facts = nullptr) const;

  const ArapReport& report() const;
  /// Faces' maps from V to U with their turns, for splines through many keys.
  SegmentMaps Maps() const;
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

/// Fills `growth` of each face: log of the linear scale of the region round it, smoothed over the
/// system's screening length.
void SetGrowth(const PoissonSystem& system, SegmentMaps& maps);

/// Path of each connected part's centroid between two keys: the body's centroid goes straight, the
/// parts' offsets turn with the body.
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
