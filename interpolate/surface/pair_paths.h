// Wanted edges of every face between two keys.
#pragma once

#include <array>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

/// Evaluates exp(t turn) K^t G(t) on each face's edges; PoissonSystem::Solve must apply body_turn.
///
/// The remainder is split into a tilt K of the face's plane and a rotation within the plane. That
/// rotation and the stretch form one 2 x 2 matrix. With Stretch::kBalanced, G(t) follows the
/// exponential of that matrix: e^(t g) exp(tau(t) log(e^-g G)). A simple shear then stays exactly a
/// simple shear. Separate powers of rotation and stretch would narrow a twisted limb. In three
/// cases K is the whole remainder and the stretch is symmetric: other kinds of stretch, a matrix
/// without a real logarithm, and turns by relative rotations. Each face has one record of
/// constants, with its edges in axes along and across those of the tilt, so that an evaluation
/// needs two products. Four times are evaluated at once.
/// Same bits for any thread count.
class PairPaths {
 public:
  /// @param v, u  the keys of `maps`
  PairPaths(const PointsX3& v, const PointsX3& u, const FacesX3& faces, const SegmentMaps& maps,
            Stretch stretch);

  /// Fills the batch's frames for the batch's faces, in the order of `times`; there are
  /// edges.frames times.
  void Evaluate(const std::vector<double>& times, EdgeBatch& edges) const;
  /// One frame with given rotations relative to the body.
  void EvaluateWith(const std::vector<Eigen::Matrix3d>& relative_rotations, double t, int frame,
                    EdgeBatch& edges) const;

  /// log G = (log_area / 2) I + N with N^2 = discriminant * I. G(t) edges = scale (cosh-like plain
  /// + sinh-like generated).
  struct Record {
    /// Unit axes: the tilt's axis and two across it. Each is split into the part that the turn
    /// keeps, and the parts that are multiplied by its cosine and by its sine.
    std::array<double, 9> along, across, third;
    /// Both edges in those axes: plain, and generated (N applied to them; for `straight`, the part
    /// that grows with t).
    std::array<std::array<double, 4>, 3> in_axes;
    double turn_angle, tilt_angle;
    double growth, log_area, discriminant;  ///< log_area: without growth
    bool straight;  ///< plain + t generated: linear stretch, faces without area
    bool flat;      ///< edges have no component along the third axis
  };

 private:
  std::vector<Record> records_;
  bool balanced_;
};

}  // namespace keypose::interpolation
