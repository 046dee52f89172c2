// Positions on a surface, described by geodesic distances to landmarks. They are the same in all
// poses.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Geodesic distances from all vertices of two meshes to pairs of landmarks.
///
/// Bending does not change these distances, so they distinguish a left leg from a right one, and a
/// tail from the leg it rests on. Differences are relative to the distance, so distant landmarks
/// have less weight.
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

  /// The scale of the target relative to the source: the 70 % quantile of the ratios of distances
  /// between landmarks. A high quantile is used because short cuts along the inside of bends make
  /// some ratios too small. It does not need a complete surface or a pose. 1 when all landmarks
  /// coincide.
  double Growth() const;
  void GrowSource(double factor) {
    source_ *= static_cast<float>(factor);
  }  ///< scales the source's distances

 private:
  Eigen::MatrixXf source_, target_;  // L x V
  std::vector<int> source_marks_, target_marks_;
};

}  // namespace keypose
