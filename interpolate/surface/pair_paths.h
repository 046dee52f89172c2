// Wanted edges of every face on its way from one key to the next.
#pragma once

#include <array>
#include <vector>

#include "core/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

/// Evaluates each face's way on its edges: exp(t turn) K^t G(t); body_turn is left to
/// PoissonSystem::Solve.
///
/// The remainder is split into a tilt K of the face's plane and a rotation within it. That rotation
/// and the stretch are one 2 x 2 matrix, and with Stretch::kBalanced G(t) goes along that matrix's
/// own exponential: e^(t g) exp(tau(t) log(e^-g G)). A simple shear is its turn and stretch in one,
/// so it stays a simple shear on the way (exactly), where powers of the two apart would narrow a
/// twisted limb. Other kinds of stretch, a matrix without real logarithm, and turns by relative
/// rotations take the whole remainder for K, and the symmetric stretch. Constants of a face are
/// kept in one record, edges in axes along and across the tilt's own, whose way needs two products;
/// four times are evaluated at once.
/// Same bits for any thread count.
class PairPaths {
 public:
  /// @param v, u  the keys of `maps`
  PairPaths(const PointsX3& v, const PointsX3& u, const FacesX3& faces, const SegmentMaps& maps,
            Stretch stretch);

  /// Fills the batch's frames of the batch's faces, in the order of `times`; as many as
  /// edges.frames.
  void Evaluate(const std::vector<double>& times, EdgeBatch& edges) const;
  /// One frame with rotations relative to the body that were found elsewhere.
  void EvaluateWith(const std::vector<Eigen::Matrix3d>& relative_rotations, double t, int frame,
                    EdgeBatch& edges) const;

  /// log G = (log_area / 2) I + N with N^2 = discriminant * I. G(t) edges = scale (cosh-like plain
  /// + sinh-like generated).
  struct Record {
    /// Unit axes: the tilt's, and two across it; each split into what the turn keeps, and what goes
    /// with its cosine and its sine.
    std::array<double, 9> along, across, third;
    /// Of both edges: plain and generated (N, or what grows with t when straight, applied to them),
    /// in those axes.
    std::array<std::array<double, 4>, 3> in_axes;
    double turn_angle, tilt_angle;
    double growth, log_area, discriminant;  ///< log_area: without growth
    bool straight;  ///< plain + t generated: linear stretch, faces without area
    bool flat;      ///< edges have no part along the third axis
  };

 private:
  std::vector<Record> records_;
  bool balanced_;
};

}  // namespace keypose::interpolation
