// The source on several levels of detail, with what pulls at each.
#pragma once

#include <optional>
#include <vector>

#include "core/landmark_goal.h"
#include "deform/arap/arap_fit.h"
#include "deform/levels/hierarchy.h"
#include "deform/levels/landmark_coordinates.h"

namespace keypose {

/// A landmark on a level: its vertex carries it rigidly.
struct Mark {
  int vertex = 0;
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();     ///< from the vertex, at rest
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< where it belongs
};

/// One level of detail and its state.
struct Level {
  PointsX3 rest;
  FacesX3 faces;
  std::vector<int> fine;  ///< the input vertex that each vertex is
  std::vector<char> rim;  ///< 1 for vertices on the boundary; empty when there are none
  std::vector<Mark> marks;
  std::vector<LandmarkCoordinates::Match> matches;  ///< one a vertex, or empty
  std::optional<ArapFit> fit;
  PointsX3 moved;
  PointsX3 feet;      ///< on the target, of the last search for closest points
  double growth = 1;  ///< of the rest shape, by which its rigid pieces would fit better
};

/// Levels from fine (the input itself) to coarse.
class Levels {
 public:
  /// @param rest       V x 3, aligned to the target, whose diagonal is 2
  /// @param stiffness  V, or empty
  /// @param landmarks  their targets in the same frame
  Levels(const PointsX3& rest, const FacesX3& faces, const std::vector<int>& coarse_counts,
         const Eigen::VectorXd& stiffness, double smoothing,
         const std::vector<LandmarkGoal>& landmarks);
  int count() const { return static_cast<int>(levels_.size()); }
  Level& operator[](int level);
  /// Gives level - 1 the positions and maps of `level`.
  void Descend(int level);
  /// Of all levels. The one last asked for is scaled now, others when they are next asked for: hold
  /// on to one at a time.
  void ScaleRest(double factor);

 private:
  std::vector<Level> levels_;
  // of each level, the factor by which its rest shape has still to grow
  std::vector<double> pending_;
  int last_asked_ = 0;
  std::vector<Prolongation> down_;    // from level l + 1 to l
  std::vector<std::vector<int>> up_;  // vertex of level l -> vertex of level l + 1
};

}  // namespace keypose
