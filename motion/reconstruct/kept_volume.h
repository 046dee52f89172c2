// Poses that keep the volume of the rest shape.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"
#include "motion/reconstruct/face_fans.h"

namespace keypose::motion {

/// How poses move along their normals so that each closed part has its volume at rest.
///
/// How far each vertex moves along its normal, relative to the others, is found once, at rest: the
/// field that gains volume at the least stretch (VolumeCorrection). So a pose costs no solve, and
/// one pass over the vertices: the gradient of the volume gives normals, volume (a third of the
/// gradient's product with the points), slope, and what pulls gain; the curvature along the field
/// is that at rest. Same bits for any thread count.
class KeptVolume {
 public:
  /// @param system  built with screening; must outlive this
  KeptVolume(const PoissonSystem& system, const PointsX3& rest);

  /// V x 3, column by column: vectors of vertices.
  using Field = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  /// A pose's volumes, and how they change.
  struct State {
    std::vector<double> volume, slope;  ///< of each part; slope: the derivative along `field`
    Eigen::MatrixXd gains;              ///< parts x 3 pulls: the derivative along each
    Field field;                        ///< 0 in open parts
    std::vector<double> sums;           // of blocks
  };
  /// @param pulls  V x any number: how far each vertex follows a pull
  /// @param state  filled; its memory is used again
  void Measure(const PointsX3& pose, const Eigen::MatrixXd& pulls, State& state) const;
  /// The volumes alone, in a fraction of the time; 0 of open parts.
  std::vector<double> Volumes(const PointsX3& pose) const;

  bool any_closed() const { return any_closed_; }
  int part_count() const { return static_cast<int>(closed_.size()); }
  /// Whether the part's volume is kept.
  bool Keeps(int part, const State& state) const { return closed_[part] && state.slope[part] > 0; }
  double Wanted(int part) const { return volume_[part]; }
  /// The step along the field that brings the missing volume, after a step of `before`.
  /// 0 where that is out of reach (a quarter of the diagonal).
  double StepFor(int part, double missing, double slope, double before) const;
  const std::vector<int>& parts() const { return system_->parts(); }

 private:
  /// Fans of one part.
  struct Block {
    int part, begin, end;
  };
  std::vector<Block> BlocksOf(const FaceFans& fans) const;

  const PoissonSystem* system_;
  std::vector<char> closed_;
  FaceFans around_, once_;  // of closed parts: each face at all of its corners, and at one
  std::vector<Block> around_blocks_, once_blocks_;
  std::vector<double> volume_, curvature_;  // of each part at rest
  Eigen::VectorXd amount_;                  // V, along the normal
  double diagonal_ = 1;
  bool any_closed_ = false;
};

}  // namespace keypose::motion
