// Poses of a surface from the turns of its marks, many frames at once.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"
#include "motion/fields/mark_fields.h"
#include "motion/fields/mark_turns.h"

namespace keypose::motion {

/// What the marks ask of one frame: either quaternions, whose components are interpolated and
/// normalised as in the paper, or rotation vectors relative to a body.
struct FrameFields {
  Eigen::Matrix3d body = Eigen::Matrix3d::Identity();  ///< applied after the fields
  Eigen::MatrixXd quaternions;  ///< M x 4 (w, x, y, z) with agreeing signs, or empty
  PointsX3 turns;               ///< M x 3, or empty
  PointsX3 remainders;          ///< M x 3, applied before the turns; or empty
  /// M x 6 or empty: logarithms of stretches (xx, yy, zz, xy, xz, yz), applied first
  Eigen::MatrixXd log_stretches;

  static FrameFields Quaternions(const std::vector<Eigen::Quaterniond>& agreeing);
  static FrameFields Turns(const MarkTurns& turns);
};

/// Minimises sum over faces and edges of cot/2 |x_j - x_i - R_face (v_j - v_i)|^2, whose normal
/// equations are the paper's L X = U_reduced. The rotations of faces come from the marks by
/// precomputed weights; the matrix is factored once.
/// Source: as LiteralTransfer, with which it agrees to 1e-10 of the diagonal.
class FrameSolver {
 public:
  /// The factored system of a mesh at rest, V x 3. It does not depend on marks, so that it can be
  /// made beside their fields.
  /// @param screened  as PoissonOptions::screened
  static PoissonSystem SystemOf(const PointsX3& rest, const FacesX3& faces, bool screened);
  /// @param rest    V x 3
  /// @param fields  of the same mesh; must outlive this
  /// @param system  SystemOf the same mesh
  FrameSolver(const PointsX3& rest, const FacesX3& faces, const MarkFields& fields,
              PoissonSystem system);

  /// @return a pose for each frame, V x 3, with the centroid of each connected part at the origin
  /// Same bits for any thread count.
  std::vector<PointsX3> Solve(const std::vector<FrameFields>& frames) const;
  /// Buffers of a batch, which are used again.
  struct Space {
    FrameRows rows;
    std::vector<PointsX3> poses;
  };
  /// The same; the poses are in `space`.
  void Solve(const std::vector<FrameFields>& frames, Space& space) const;
  /// One frame by itself: as Solve to 1e-11 of the diagonal, in a fraction of the time.
  PointsX3 SolveOne(const FrameFields& frame) const;
  /// The rotation of one vertex, as the fields ask it.
  Eigen::Matrix3d RotationAt(int vertex, const FrameFields& frame) const;
  const PoissonSystem& system() const { return system_; }

 private:
  struct PatchTurns;
  void CutPatches();
  int place_count() const;
  std::vector<double> TurnsOf(const FrameFields& frame) const;
  using TakeEdges = std::function<void(int k, const Eigen::Matrix<double, 3, 2>& edges)>;
  void StretchPatch(int patch, const FrameFields& frame, const TakeEdges& take) const;

  const MarkFields& fields_;
  PoissonSystem system_;
  /// Places at which fields are mixed: the vertices, then the marked faces. Of a face: its corners,
  /// or itself three times.
  FacesX3 corners_;
  struct Patch {
    std::vector<int> places;
    std::vector<int> corners;  // of each of its faces three, among `places`
  };
  std::vector<Patch> patches_;  // of the system
  // of each face at rest: corner 0 -> 1, then 0 -> 2; and one number more, as edges are read by
  // fours
  std::vector<double> edges_;
};

}  // namespace keypose::motion
