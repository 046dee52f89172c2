// Vertices from wanted edges: the one linear system behind frames between two keys and through
// many.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh.h"

namespace keypose {

/// Wanted edges of every face at several frames: what the faces' maps make of the edges corner 0 ->
/// 1 and corner 0 -> 2.
struct EdgeBatch {
  /// Of all faces of a mesh.
  EdgeBatch(Eigen::Index faces, int frame_count);
  /// Of some: face k is listed[k]. The list must outlive this.
  EdgeBatch(std::span<const int> listed, int frame_count);
  /// @param edges  3 x 2: columns are corner 1 - corner 0 and corner 2 - corner 0
  void Set(Eigen::Index face, int frame, const Eigen::Matrix<double, 3, 2>& edges);
  /// 6 x stride numbers of a face: x y z of the first edge, then of the second; a frame is a
  /// column.
  double* Face(Eigen::Index face) { return values_.get() + face * 6 * stride; }
  const double* Face(Eigen::Index face) const { return values_.get() + face * 6 * stride; }

  int frames = 0, stride = 0;   ///< stride: frames rounded up to whole vectors
  std::span<const int> listed;  ///< empty: all faces

 private:
  std::unique_ptr<double[]> values_;
};

/// Positions of all vertices at several frames, a row a vertex: `stride` numbers of x, of y, of z,
/// a frame a column.
struct FrameRows {
  FrameRows(Eigen::Index vertices, int frame_count);
  double* Row(Eigen::Index row) { return values.get() + row * 3 * stride; }
  const double* Row(Eigen::Index row) const { return values.get() + row * 3 * stride; }

  int frames = 0, stride = 0;  ///< stride: frames rounded up to whole vectors
  std::unique_ptr<double[]> values;
};

/// Writes wanted edges of the batch's faces at the frames first .. first + edges.frames - 1. Called
/// from several threads at once.
using FillEdges = std::function<void(int first, EdgeBatch& edges)>;

/// One linear condition, on x, y and z alike: sum of weight * position over `terms` equals a target
/// point, given anew for each frame.
struct ConstraintRow {
  std::vector<std::pair<int, double>> terms;  ///< vertex, weight
  /// 0: exact. Else a spring: |C x - d|^2 / (2 compliance) joins the energy
  double compliance = 0;
  std::string name;  ///< for messages and reports
};

/// No listed vertex (all, when none is listed) may lie below z = height.
struct Floor {
  double height = 0;
  std::vector<int> vertices;
};

using KeyRefs = std::vector<std::reference_wrapper<const PointsX3>>;
using RowTargets = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

struct PoissonOptions {
  /// also factor H + kappa M, for SolveScreened, SmoothOverVertices and WithoutRows
  bool screened = true;
  double screening_over_diagonal = 0.1;  ///< 1 / sqrt(kappa), over the mean diagonal of the keys
};

/// Minimises sum over keys, faces and edges of cot/2 |x_j - x_i - wanted edge|^2 under linear
/// conditions, for many frames at once.
///
/// H, the sum of the keys' cotangent Laplacians, is constant: factored once, 3 right-hand sides a
/// frame. Conditions come in by Lagrange multipliers (a dense system of as many unknowns as rows),
/// so H is never factored again. Each connected part without an exact row gets one for its
/// centroid: rows() lists the given ones that could be kept, then those. A part held by springs
/// alone gets none where a spring's weights do not cancel.
/// Same bits for any thread count.
/// Source: Alexa et al. 2000 for the energy; Lagrange multipliers by Schur complement.
class PoissonSystem {
 public:
  /// @param keys  one or more, each V x 3; faces without area in any of them get the weights of a
  /// small equilateral triangle
  /// @throws InputError   a row names a vertex that is not there, or a weight that is not finite
  /// @throws SolverError  cannot be factored
  PoissonSystem(const KeyRefs& keys, const FacesX3& faces,
                const std::vector<ConstraintRow>& rows = {}, const PoissonOptions& options = {});
  ~PoissonSystem();
  PoissonSystem(PoissonSystem&&) noexcept;

  int vertex_count() const;
  const FacesX3& faces() const;
  /// Connected part of each vertex: 0 .. part_count() - 1, in order of their lowest vertices.
  const std::vector<int>& parts() const;
  int part_count() const;
  /// Summed over the keys; 0 for faces without area in any.
  const Eigen::VectorXd& face_areas() const;

  /// Rows in use. Targets are given in this order.
  const std::vector<ConstraintRow>& rows() const;
  /// For each row in use: its place in the constructor's list, or -1 - part where it is a part's
  /// centroid.
  const std::vector<int>& row_sources() const;
  /// Names of given rows that follow from earlier ones (within 1e-9) and were left out.
  const std::vector<std::string>& dropped_rows() const;
  /// The points' own values of the rows in use.
  RowTargets RowsAt(const PointsX3& points) const;

  /// @param edges    wanted edges of the frames
  /// @param targets  one a frame, rows().size() x 3
  /// @param turns    one a frame, or none: the wanted edges are turned by it first
  std::vector<PointsX3> Solve(const EdgeBatch& edges, const std::vector<RowTargets>& targets,
                              const std::vector<Eigen::Matrix3d>& turns = {}) const;

  /// The same, for edges that are made as they are needed, a patch of faces and a few frames at a
  /// time.
  std::vector<PointsX3> Solve(int frames, const FillEdges& fill,
                              const std::vector<RowTargets>& targets,
                              const std::vector<Eigen::Matrix3d>& turns = {}) const;

  /// Whether no part has a row but its centroid's.
  bool IsFree() const;
  /// The frames of a free system before its centroids are placed: each part's lowest vertex stays
  /// at the origin. Row row_of()[i] is vertex i; neighbours lie near each other.
  FrameRows SolveFree(int frames, const FillEdges& fill) const;
  const std::vector<int>& row_of() const;

  /// The smallest change, in this energy and under the same conditions, after which z >=
  /// floor.height: active vertices are held at the floor by multipliers until none sinks and none
  /// is pulled. In place; exact to rounding.
  /// @return vertices held
  /// @throws InputError  a row holds vertices below the floor, so both cannot be true
  std::vector<int> LiftToFloor(PointsX3& points, const Floor& floor) const;

  /// (H + kappa M)^-1 b: smooth over 1 / sqrt(kappa), local beyond. M: a third of the faces' areas,
  /// summed over keys, on the diagonal.
  Eigen::MatrixXd SolveScreened(const Eigen::MatrixXd& b) const;
  /// Values of faces, F x C, as smooth values of vertices, V x C: kappa (H + kappa M)^-1 M, applied
  /// `passes` times. Keeps constants; what varies over a length l falls to 1 / (1 + (2 pi
  /// screening_length / l)^2) with each pass.
  Eigen::MatrixXd SmoothOverVertices(const Eigen::MatrixXd& face_values, int passes = 1) const;
  /// A displacement made to keep all exact rows (and z of `held` vertices), changed as little as
  /// possible in the screened norm.
  PointsX3 WithoutRows(PointsX3 displacement, const std::vector<int>& held = {}) const;
  /// Screening length, 1 / sqrt(kappa).
  double screening_length() const;

 private:
  struct Impl;
  class FloorSearch;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
