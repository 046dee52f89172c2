// The mesh that is bent into films: its faces, a coarser copy on which it is bent, and frames that
// turn with its vertices.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/surfaces/face_pairs.h"
#include "core/values/mesh.h"
#include "deform/levels/hierarchy.h"

namespace keypose::fit {

class FollowedMesh {
 public:
  /// @param first          V x 3 of the first frame
  /// @param most_vertices  of the coarser copy; meshes up to a third above it are bent themselves
  FollowedMesh(const PointsX3& first, const FacesX3& faces, int most_vertices);

  const FacesX3& faces() const { return faces_; }
  const FacesX3& coarse_faces() const { return coarse_ ? coarse_->faces : faces_; }
  const FacePairs& pairs() const { return pairs_; }
  double unit() const { return unit_; }  ///< half of the first frame's diagonal
  int coarse_count() const { return static_cast<int>(coarse_first_.rows()); }
  /// The coarse vertex that each of the V vertices follows.
  const std::vector<int>& cell_of() const { return cell_of_; }
  /// The vertex of each coarse one.
  const std::vector<int>& fine_of() const { return fine_of_; }

  PointsX3 Coarse(const PointsX3& points) const;
  /// How each coarse vertex has turned since the first frame.
  /// @param coarse  C x 3
  std::vector<Eigen::Matrix3d> TurnsOf(const PointsX3& coarse) const;
  /// Positions of all vertices: each follows the coarse ones near it.
  /// @param base   V x 3, before bending
  /// @param moved  C x 3
  /// @param maps   C, from `base` to `moved`
  PointsX3 Fine(const PointsX3& base, const PointsX3& moved,
                const std::vector<Eigen::Matrix3d>& maps) const;
  /// The map of the coarse vertex that each vertex follows.
  std::vector<Eigen::Matrix3d> FineMaps(const std::vector<Eigen::Matrix3d>& maps) const;

 private:
  FacesX3 faces_;
  FacePairs pairs_;
  double unit_ = 1;
  std::optional<CoarseLevel> coarse_;
  std::optional<Prolongation> down_;
  PointsX3 coarse_first_, coarse_normals_;
  std::vector<int> cell_of_, fine_of_;
};

}  // namespace keypose::fit
