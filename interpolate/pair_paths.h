// Wanted edges of every face on its way from one key to the next.
#pragma once

#include <array>
#include <vector>

#include "core/mesh.h"
#include "interpolate/face_maps.h"
#include "interpolate/poisson.h"

namespace keypose::interpolation {

/// Evaluates exp(t turn) exp(t remainder) S(t) on each face's edges; body_turn is left to PoissonSystem::Solve.
///
/// Constants of a face are kept in one record; four times are evaluated at once. Same bits with and without AVX2, and for any thread count.
class PairPaths {
 public:
  /// @param v, u  the keys of `maps`
  PairPaths(const PointsX3& v, const PointsX3& u, const FacesX3& faces, const SegmentMaps& maps, Stretch stretch);

  /// Fills the batch's frames, in the order of `times`; as many as edges.frames.
  void Evaluate(const std::vector<double>& times, EdgeBatch& edges) const;
  /// One frame with rotations relative to the body that were found elsewhere.
  void EvaluateWith(const std::vector<Eigen::Matrix3d>& relative_rotations, double t, int frame, EdgeBatch& edges) const;

  /// S(t) = shrink(t) I + ratio(t) P, applied to both edges: shrink * plain + ratio * projected.
  struct Record {
    std::array<double, 3> turn_axis, remainder_axis;
    double turn_angle, remainder_angle;
    std::array<double, 6> plain, projected;
    double log_high, log_low, growth, log_area;  ///< of the stretch without growth: logarithms of its eigenvalues, and their sum
    double linear_low, linear_ratio;             ///< linear: shrink = 1 - t + t low, ratio = t * this
    bool straight;                               ///< edges go straight or stretch is linear: no exponentials
  };

 private:
  std::vector<Record> records_;
  bool balanced_;
};

}  // namespace keypose::interpolation
