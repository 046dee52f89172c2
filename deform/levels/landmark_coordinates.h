// Where a point lies along the surface, told by its distances to the landmarks: the same in every
// pose.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"

namespace keypose {

/// Distances over the surface from every vertex of two meshes to landmarks that belong together.
///
/// Bending keeps them, so they tell a left leg from a right one, and a tail from the leg it rests
/// on. Far landmarks count less: a difference is judged relative to the distance.
class LandmarkCoordinates {
 public:
  /// @param source_marks, target_marks  L vertices each, in pairs; L >= 1
  LandmarkCoordinates(const PointsX3& source, const FacesX3& source_faces,
                      const std::vector<int>& source_marks, const PointsX3& target,
                      const FacesX3& target_faces, const std::vector<int>& target_marks);
  struct Match {
    int vertex = -1;      ///< of the target
    double mismatch = 0;  ///< root mean square of the relative differences
  };
  /// The target vertex with the most similar distances, for each of `vertices` of the source.
  std::vector<Match> MatchVertices(const std::vector<int>& vertices) const;
  /// Mismatch between a source vertex and a point of the target's face.
  double Mismatch(int source_vertex, const Eigen::Vector3i& corners,
                  const Eigen::Vector3d& barycentric) const;

  /// The factor by which the target is larger, from the ratios of the landmarks' distances to each
  /// other: their 70 % quantile, since short cuts along the inside of bends make some small. It
  /// needs no whole surface and no pose. 1 when all landmarks coincide.
  double Growth() const;
  void GrowSource(double factor) {
    source_ *= static_cast<float>(factor);
  }  ///< as if the source were larger

 private:
  Eigen::MatrixXf source_, target_;  // L x V
  std::vector<int> source_marks_, target_marks_;
};

}  // namespace keypose
