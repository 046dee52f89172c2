// Where the marks belong on the target, from where they are on the template.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/mark_turns.h"

namespace keypose::motion {

/// Carries the vectors between neighbouring marks over to other proportions.
///
/// Turns alone say how a limb bends, but not at which place between two marks. The vector d from a
/// mark's parent to the mark, d0 at rest, tells. With D0 the target's own vector at rest, G its
/// turn half-way between the two marks and F the template's (they differ where the target holds a
/// limb otherwise at rest),
///
///     D = G D0 + |D0| / |d0| (d - F d0).
///
/// On a target that equals the template D = d; on any other the difference from the bare turn is
/// scaled by the limb.
class MarkChain {
 public:
  /// @param on_template, on_target  M x 3, marks in the reference poses
  MarkChain(MarkTree tree, const PointsX3& on_template, const PointsX3& on_target,
            const Eigen::Matrix3d& target_from_template);
  /// @param on_template  M x 3, marks of the template in a frame
  /// @param turns        of the target's marks
  /// @param rest_turns   of the marks, from the target's reference pose to the template's
  /// @return M x 3, places of the target's marks, up to a common translation
  PointsX3 At(const PointsX3& on_template, const MarkTurns& turns,
              const std::vector<Eigen::Quaterniond>& rest_turns) const;

 private:
  MarkTree tree_;
  PointsX3 on_template_, on_target_;
  Eigen::Matrix3d turn_;
  std::vector<double> ratio_;  // of each mark's step
};

}  // namespace keypose::motion
