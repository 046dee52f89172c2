// The path of the body: the template's, with the target's directions and proportions.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/marks.h"
#include "motion/reconstruct/frame_solver.h"

namespace keypose::motion {

/// The turn that the alignment asks for. Meshes that stand upright (within 30 degrees of z) keep
/// their uprights and only turn about z, and a heading under 20 degrees, which differing shapes can
/// give, is none. Identity when the alignment is not certain.
Eigen::Matrix3d DirectionsOf(const Alignment& alignment);

struct RootPathOptions {
  double scale = 0;  ///< of the path; 0: the ratio of the roots' heights above their grounds
};

/// The root is the mean of some marks, the most central ones. Its way from the reference pose is
/// the template's, turned and scaled.
class RootPath {
 public:
  /// @param on_template, on_target  M x 3, marks in the reference poses
  /// @param template_ground, target_ground  heights (z) on which they stand
  /// @param root          the marks that stand for the body
  /// @param overall_scale  of the target over the template; used where no height tells
  RootPath(const PointsX3& on_template, const PointsX3& on_target, double template_ground,
           double target_ground, std::vector<int> root, double overall_scale,
           const Eigen::Matrix3d& target_from_template, const RootPathOptions& options);

  double scale() const { return scale_; }
  /// Mean of the root's marks.
  Eigen::RowVector3d RootOf(const PointsX3& marks) const;
  /// Where the target's root is, when the template's marks are here.
  Eigen::RowVector3d At(const PointsX3& on_template) const;
  /// A point of the template's reference pose, in the target's space.
  Eigen::RowVector3d OnTarget(const Eigen::RowVector3d& point) const {
    return target_root_ + scale_ * (point - template_root_) * turn_.transpose();
  }
  /// Points of the target's space in the template's: what OnTarget undoes.
  PointsX3 OnTemplate(const PointsX3& points) const {
    PointsX3 moved = (points.rowwise() - target_root_) / scale_ * turn_;
    moved.rowwise() += template_root_;
    return moved;
  }
  /// The most central mark: it lies on the main part.
  int central_mark() const { return root_[0]; }

 private:
  std::vector<int> root_;
  Eigen::Matrix3d turn_;
  double scale_ = 1;
  Eigen::RowVector3d template_root_, target_root_;
};

/// Places each connected part where the nearest vertex of the main part carries it.
class JoinedParts {
 public:
  /// @param main_vertex  any vertex of the main part
  JoinedParts(const PoissonSystem& system, const PointsX3& rest, int main_vertex);
  /// @param pose  V x 3, each part's centroid at the origin; changed in place, all but the main
  /// part
  void Join(const FrameSolver& solver, const FrameFields& frame, PointsX3& pose) const;

 private:
  struct Rider {
    int part, carrier;             // a vertex of the main part
    Eigen::Vector3d from_carrier;  // to the part's centroid, at rest
  };
  std::vector<Rider> riders_;
  std::vector<int> parts_;  // of the vertices
};

}  // namespace keypose::motion
