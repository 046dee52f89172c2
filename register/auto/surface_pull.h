// The pulls of a target surface on a mesh that is bent onto it.
#pragma once

#include <memory>
#include <vector>

#include "core/values/mesh.h"
#include "deform/arap/arap_fit.h"

namespace keypose::registration {

struct SurfacePullTerms {
  double weight = 1;  ///< of the whole surface, in units of ArapFit's shape term; divided among the
                      ///< vertices by area
  double robust = 0.1;  ///< distance at which a pull has a quarter of its weight (Geman-McClure)
                        ///< [length]
  int samples = 3000;   ///< about how many target vertices pull back
  bool measure = true;  ///< whether to compute the distances in SurfaceGap
};

/// The distance between the two surfaces. Both distances use the closest 95 % only.
struct SurfaceGap {
  double forward = 0;   ///< root mean square distance of the mesh's vertices to their points on the
                        ///< target, weighted by area [length]
  double backward = 0;  ///< root mean square distance of the matched mesh vertices to the planes of
                        ///< the target's samples [length]
  double rejected = 0;  ///< share of the mesh's area without a point on the target
};

/// A target surface, with its search structures.
class SurfacePull {
 public:
  /// @throws InputError  unusable mesh
  SurfacePull(const PointsX3& points, const FacesX3& faces);
  ~SurfacePull();

  /// Adds pulls in both directions. Forward: every vertex goes to the plane at its closest point on
  /// the target. Backward: the vertex nearest to each target sample goes to that sample's plane,
  /// which draws out the ends of limbs.
  ///
  /// A closest point on the target's boundary, or with a different normal, does not pull. Then the
  /// nearest target vertex with a similar normal and not on the boundary is used, if it is among
  /// the 24 nearest. Exception: a vertex on the mesh's own boundary may go to the target's
  /// boundary.
  /// @param moved      V x 3, current positions
  /// @param rim        V, 1 for vertices on the mesh's own boundary, or empty
  /// @param areas      V, area of each vertex
  /// @param last_feet  V x 3, closest points of the last search, or empty; they only save time.
  ///                   Receives those of this search.
  /// @param pulls      receives the pulls
  /// @return the gap between the surfaces before the mesh moves
  /// Same bits for any thread count.
  SurfaceGap Add(const PointsX3& moved, const FacesX3& faces, const std::vector<char>& rim,
                 const Eigen::VectorXd& areas, const SurfacePullTerms& terms, PointsX3& last_feet,
                 Pulls& pulls) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::registration
