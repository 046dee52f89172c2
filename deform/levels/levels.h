// The source mesh at several levels of detail, with the landmarks and the fit of each.
#pragma once

#include <optional>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/size_of.h"
#include "deform/arap/arap_fit.h"
#include "deform/levels/hierarchy.h"
#include "deform/levels/landmark_coordinates.h"

namespace keypose {

/// A landmark on a level. It moves rigidly with its vertex.
struct Mark {
  int vertex = 0;
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();     ///< from the vertex, at rest
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< its goal
};

/// One level of detail and its state.
struct Level {
  PointsX3 rest;
  FacesX3 faces;
  std::vector<int> fine;  ///< the input mesh's vertex of each vertex
  std::vector<char> rim;  ///< 1 for vertices on the boundary; empty when there are none
  std::vector<Mark> marks;
  std::vector<LandmarkCoordinates::Match> matches;  ///< one a vertex, or empty
  std::optional<ArapFit> fit;
  PointsX3 moved;
  PointsX3 feet;      ///< closest points on the target, of the last search
  double growth = 1;  ///< factor on the rest shape by which its rigid pieces would fit better
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
  int count() const { return SizeOf(levels_); }
  Level& operator[](int level);
  /// Transfers the positions and maps of `level` to level - 1.
  void Descend(int level);
  /// Scales the rest shape of all levels. The level that was accessed last is scaled now, the
  /// others on their next access. So keep a reference to one level at a time only.
  void ScaleRest(double factor);

 private:
  std::vector<Level> levels_;
  // for each level, the scale that is still to be applied to its rest shape
  std::vector<double> pending_;
  int last_asked_ = 0;
  std::vector<Prolongation> down_;    // from level l + 1 to l
  std::vector<std::vector<int>> up_;  // vertex of level l -> vertex of level l + 1
};

}  // namespace keypose
