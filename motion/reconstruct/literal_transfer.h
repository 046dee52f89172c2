// The paper's transfer, step by step as it is written: slow, and the oracle of frame_solver.h.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::motion {

/// 1. Each component of the marks' quaternions is a scalar field, constrained at the corners of the
///    marked triangles; four Laplace equations are solved.
/// 2. The quaternions of a triangle's corners are averaged and normalised: its rotation. A marked
///    triangle keeps its own.
/// 3. Each triangle is rotated by itself, which gives a fragmented mesh of 3 F vertices.
/// 4. The Laplacian of the fragmented mesh is applied to its coordinates; the 3 F results are
///    summed by the vertices of the mesh: U_reduced.
/// 5. L X = U_reduced is solved with a factor that was made once.
///
/// The paper leaves three things open. Where a vertex belongs to several marks, it takes their
/// mean. L is singular by a translation: the first vertex is held, and the caller places the
/// result. The signs of the quaternions must agree (WithAgreeingSigns). Source: de Aguiar et al.,
/// animation of human scans from multi-view video, Section 4, Eq. 1-2.
class LiteralTransfer {
 public:
  /// @throws InputError  a triangle without area, or more than one connected part
  /// @throws SolverError
  LiteralTransfer(const PointsX3& points, const FacesX3& faces,
                  const std::vector<int>& marked_faces);
  ~LiteralTransfer();

  /// @param rotations  one unit quaternion for each mark
  /// @return V x 3; the first vertex where it is at rest
  PointsX3 Pose(const std::vector<Eigen::Quaterniond>& rotations) const;
  /// Steps 1 and 2 alone: F rotations.
  std::vector<Eigen::Quaterniond> FaceRotations(
      const std::vector<Eigen::Quaterniond>& rotations) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::motion
