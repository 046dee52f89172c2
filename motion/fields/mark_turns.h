// How the marks turn, from frame to frame: values for the fields between them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/marks.h"

namespace keypose::motion {

/// A tree that joins all marks over the shortest ways along the surface.
struct MarkTree {
  struct Step {
    int mark, parent;  ///< parent == mark at the root
  };
  std::vector<Step> steps;                ///< each mark after its parent
  std::vector<std::vector<int>> nearest;  ///< of each mark the six (or fewer) nearest others
  std::vector<int> central;  ///< marks by their mean distance from all others, the nearest first
};

/// @param places  of the marks on this mesh
/// Distances are measured on a decimated copy of at most 2000 vertices.
MarkTree JoinMarks(const PointsX3& points, const FacesX3& faces,
                   const std::vector<MarkPlace>& places);

/// The same rotations as unit quaternions whose signs agree: w >= 0 at the root, and a product >= 0
/// with the parent at each other mark. So the sign of an input does not matter.
std::vector<Eigen::Quaterniond> WithAgreeingSigns(const MarkTree& tree,
                                                  const std::vector<Eigen::Quaterniond>& given);

/// Rotations of the marks in one frame, split into that of the body and turns relative to it.
struct MarkTurns {
  Eigen::Matrix3d body = Eigen::Matrix3d::Identity();
  PointsX3 turns;  ///< M x 3, rotation vectors of any length
  /// M x 3, or empty where all are zero: rotation = body * exp(turn) * exp(remainder)
  PointsX3 remainders;
};

/// Lifts the marks' rotations of a motion, frame by frame, to rotation vectors of any length.
///
/// The body is the mean of the third of the marks that are nearest to all others. A mark's vector
/// continues that of the frame before, if the mark turned by less than a right angle since then;
/// else it takes the vector nearest to that of its parent in the tree. So a mark may turn by any
/// angle against its neighbour, if it does so over several frames.
class TurnFollower {
 public:
  /// @param follow  false: each frame by itself, with the shortest vectors; for limbs that circle
  explicit TurnFollower(MarkTree tree, bool follow = true);
  /// @param rotations  of all marks in the next frame; the sign of a quaternion does not matter
  MarkTurns Next(const std::vector<Eigen::Quaterniond>& rotations);
  /// The largest difference of the vectors of two neighbouring marks so far [rad].
  double largest_between() const { return largest_between_; }

 private:
  Eigen::Quaterniond BodyOf(const std::vector<Eigen::Quaterniond>& rotations) const;

  MarkTree tree_;
  bool follow_;
  std::vector<Eigen::Quaterniond> before_;  // relative to the body; empty before the first frame
  std::vector<Eigen::Vector3d> turns_;
  double largest_between_ = 0;
};

/// How many of the marks, the most central ones, stand for the body.
int BodyMarks(int marks);

}  // namespace keypose::motion
