// The last steps for many frames at once, on rows of a free system: volumes, centroids, and the
// frames themselves.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/turns/turning_field.h"

namespace keypose::interpolation {

/// Works on frames as PoissonSystem::SolveFree returns them: four frames at a time, by patches of
/// neighbouring rows.
///
/// Each vertex moves by a step along a TurningField without its body turn; there is one step per
/// part and frame. Then the body turns, and each part is shifted to its place. The sums that the
/// steps and shifts need are computed first, in one pass over rows and faces. They are added by
/// patch, then over patches in order: the same bits for any thread count.
class RowFrames {
 public:
  /// @param system  must outlive this, as must the field
  /// @param field   of steps, or null if nothing moves
  RowFrames(const PoissonSystem& system, const TurningField* field);

  /// Sums over one part at one frame.
  struct PartSums {
    /// of points + x field, as a polynomial in x; for closed parts
    std::array<double, 4> volume = {};
    Eigen::Vector3d point = Eigen::Vector3d::Zero(), field = Eigen::Vector3d::Zero();  ///< means
    double longest = 0;  ///< longest vector of the field
  };
  /// frames x parts
  std::vector<std::vector<PartSums>> Sums(const FrameRows& rows,
                                          const std::vector<double>& times) const;

  struct Move {
    double step = 0;        ///< along the field
    Eigen::Vector3d shift;  ///< after the turn
  };
  /// @param bodies  rotations of the body, one per frame
  /// @param moves   frames x parts
  std::vector<PointsX3> Frames(const FrameRows& rows, const std::vector<double>& times,
                               const std::vector<Eigen::Matrix3d>& bodies,
                               const std::vector<std::vector<Move>>& moves) const;

 private:
  /// Rows begin .. end, all of one part, and the faces whose lowest row is among them.
  struct Patch {
    int part, begin, end;
    // indices into vertices_: first the rows', then the faces' others
    int first_vertex, last_vertex;
    int first_face, last_face;  // indices into faces_
  };
  const PoissonSystem* system_;
  const TurningField* field_;
  std::vector<Patch> patches_;
  std::vector<int> vertices_, rows_;       // for each place in a patch
  std::vector<std::array<int, 3>> faces_;  // as places in their patch
};

}  // namespace keypose::interpolation
