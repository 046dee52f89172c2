// What a target surface asks of a mesh that is being bent onto it.
#pragma once

#include <memory>
#include <vector>

#include "core/mesh.h"
#include "deform/arap/arap_fit.h"

namespace keypose::registration {

struct SurfacePullTerms {
  double weight = 1;  ///< of the whole surface, in units of ArapFit's shape term; a vertex gets its
                      ///< share of the area
  double robust = 0.1;  ///< distance at which a pull counts a quarter (Geman-McClure) [length]
  /// pulls are onto planes; this share of them is onto the points themselves
  double point_share = 0.03;
  int samples = 3000;       ///< about how many of the target's vertices pull back
  double min_cosine = 0.5;  ///< between the normals of two points that may belong together
  bool measure = true;      ///< whether to say how far the surfaces are apart
};

/// How far the two surfaces are apart.
struct SurfaceGap {
  double forward = 0;  ///< root mean square distance of the mesh's vertices to compatible points of
                       ///< the target, by area, trimmed to the closest 95 % [length]
  double backward = 0;  ///< the same for the target's samples
  double rejected = 0;  ///< share of the mesh's area that faces nothing compatible
};

/// A target, ready to pull.
class SurfacePull {
 public:
  /// @throws InputError  unusable
  SurfacePull(const PointsX3& points, const FacesX3& faces);
  ~SurfacePull();

  /// Adds pulls of both ways: every vertex towards the plane of its closest compatible point of the
  /// target, and the vertices nearest to the target's samples towards those, so that the ends of
  /// limbs are drawn out. A closest point that lies on the target's boundary, or whose normal
  /// differs, does not pull; then the nearest of the next 24 vertices whose normal agrees does. But
  /// the rim of the mesh is believed to belong on the target's.
  /// Same bits for any thread count.
  /// @param rim  V, 1 for vertices on the mesh's own boundary, or empty
  /// @param last_feet  V x 3, the closest points of the last search or empty, which only saves
  /// time; then those of this one
  SurfaceGap Add(const PointsX3& moved, const FacesX3& faces, const std::vector<char>& rim,
                 const Eigen::VectorXd& areas, const SurfacePullTerms& terms, PointsX3& last_feet,
                 Pulls& pulls) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::registration
