// Poses of the target that stand where they belong: body, parts and marks.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/mark_fields.h"
#include "motion/fields/marks.h"
#include "motion/reconstruct/frame_solver.h"
#include "motion/root/root_path.h"

namespace keypose::motion {

/// What one frame asks of the target.
struct MotionFrame {
  FrameFields fields;
  Eigen::RowVector3d root = Eigen::RowVector3d::Zero();  ///< mean of the root's marks
  PointsX3 marks;  ///< M x 3, up to a translation (MarkChain); or empty
};

class PlacedPoses {
 public:
  /// @param places    of the marks on this mesh
  /// @param fields    of the same mesh and marks; must outlive this, as must `path`
  /// @param system    FrameSolver::SystemOf the mesh
  /// @param screened  whether the system is; needed where frames have places of marks
  PlacedPoses(const PointsX3& rest, const FacesX3& faces, std::vector<MarkPlace> places,
              const MarkFields& fields, const RootPath& path, PoissonSystem system, bool screened);

  /// Solves the frames, joins the parts, moves each pose to its root, and the marks to their places
  /// by a smooth displacement: the harmonic weights of the marks, smoothed over a tenth of the
  /// diagonal and combined so that each mark is where it belongs.
  /// Same bits for any thread count.
  std::vector<PointsX3> Make(std::span<const MotionFrame> frames) const;
  /// The same; the poses are in `space`, whose memory is used again.
  void Make(std::span<const MotionFrame> frames, FrameSolver::Space& space) const;
  /// One frame by itself, as Make to rounding.
  PointsX3 MakeOne(const MotionFrame& frame) const;
  const FrameSolver& solver() const { return solver_; }
  PointsX3 MarksOf(const PointsX3& pose) const;

 private:
  /// Moves joined poses to their roots, and marks to their places.
  void Place(std::span<const MotionFrame> frames, std::span<PointsX3> poses) const;

  FacesX3 faces_;
  std::vector<MarkPlace> places_;
  const RootPath& path_;
  FrameSolver solver_;
  JoinedParts joined_;
  Eigen::MatrixXd carried_;  // V x M: what a move of a mark does to each vertex; or empty
};

}  // namespace keypose::motion
