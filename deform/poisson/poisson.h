// Vertex positions from wanted edges: the linear system for frames between two keys and through
// many keys.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Wanted edges of faces at several frames: the edges corner 0 -> 1 and corner 0 -> 2 after each
/// face's map.
struct EdgeBatch {
  /// Of all faces of a mesh.
  EdgeBatch(Eigen::Index faces, int frame_count);
  /// Of some faces: face k is listed[k]. The list must outlive this object.
  EdgeBatch(std::span<const int> listed, int frame_count);
  /// @param edges  3 x 2: columns are corner 1 - corner 0 and corner 2 - corner 0
  void Set(Eigen::Index face, int frame, const Eigen::Matrix<double, 3, 2>& edges);
  /// The 6 x stride numbers of a face: x, y, z of the first edge, then of the second. Each frame is
  /// a column.
  double* Face(Eigen::Index face) { return values_.get() + face * 6 * stride; }
  const double* Face(Eigen::Index face) const { return values_.get() + face * 6 * stride; }

  int frames = 0, stride = 0;   ///< stride: frames rounded up to whole vectors
  std::span<const int> listed;  ///< empty: all faces
  int patch = -1;               ///< of PoissonSystem, whose faces are listed; -1: no patch

 private:
  std::unique_ptr<double[]> values_;
};

/// Positions of all vertices at several frames. The row of a vertex has `stride` numbers for x,
/// then for y and z. Each frame is a column.
struct FrameRows {
  FrameRows() = default;
  FrameRows(Eigen::Index vertices, int frame_count);
  double* Row(Eigen::Index row) { return values.get() + row * 3 * stride; }
  const double* Row(Eigen::Index row) const { return values.get() + row * 3 * stride; }

  Eigen::Index vertices = 0;
  int frames = 0, stride = 0;  ///< stride: frames rounded up to whole vectors
  std::unique_ptr<double[]> values;
};

/// Writes the wanted edges of the batch's faces at the frames first .. first + edges.frames - 1.
/// Several threads call it at once.
using FillEdges = std::function<void(int first, EdgeBatch& edges)>;

/// Writes the wanted edges of a patch's faces in one frame: eight numbers a face, x y z 0 of the
/// first edge, then of the second. Several threads call it at once.
using FillOneFrame = std::function<void(int patch, double* edges)>;

/// One linear constraint, the same for x, y and z: the sum of weight * position over `terms` equals
/// a target point, which differs from frame to frame.
struct ConstraintRow {
  std::vector<std::pair<int, double>> terms;  ///< vertex, weight
  /// 0: exact. Else a spring: |C x - d|^2 / (2 compliance) is added to the energy
  double compliance = 0;
  std::string name;  ///< for messages and reports
};

/// The listed vertices (all, when none is listed) must not lie below z = height.
struct Floor {
  double height = 0;
  std::vector<int> vertices;
};

using KeyRefs = std::vector<std::reference_wrapper<const PointsX3>>;
using RowTargets = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

struct PoissonOptions {
  /// also factor H + kappa M, for SolveScreened, SmoothOverVertices and WithoutRows
  bool screened = true;
  bool dissected = false;  ///< as in BlockCholesky::Analyze: for hundreds of frames
};

/// Minimises the sum over keys, faces and edges of cot/2 |x_j - x_i - wanted edge|^2 under linear
/// constraints, for many frames at once.
///
/// H, the sum of the keys' cotangent Laplacians, is constant. It is factored once, and each frame
/// has 3 right-hand sides. Constraints are added by Lagrange multipliers (a dense system with one
/// unknown for each row), so H is not factored again. A connected part that the given rows do not
/// place, so that it could still be shifted, gets an exact row for its centroid. A row whose
/// weights cancel does not place a part. rows() lists the accepted given rows, then the centroid
/// rows.
/// Same bits for any thread count.
/// Source: Alexa et al. 2000 for the energy; Lagrange multipliers by Schur complement.
class PoissonSystem {
 public:
  /// @param keys  one or more, each V x 3; a face without area in any of them gets the weights of a
  /// small equilateral triangle
  /// @throws InputError   a row names a vertex that does not exist, or a weight that is not finite
  /// @throws SolverError  cannot be factored
  PoissonSystem(const KeyRefs& keys, const FacesX3& faces,
                const std::vector<ConstraintRow>& rows = {}, const PoissonOptions& options = {});
  ~PoissonSystem();
  PoissonSystem(PoissonSystem&&) noexcept;

  int vertex_count() const;
  const FacesX3& faces() const;
  /// Patches of faces, for which edges are asked. A face can be in several.
  int patch_count() const;
  std::span<const int> FacesOfPatch(int patch) const;
  /// Connected part of each vertex: 0 .. part_count() - 1, in order of their lowest vertices.
  const std::vector<int>& parts() const;
  int part_count() const;
  /// Face areas, summed over the keys; 0 for a face that has no area in at least one key.
  const Eigen::VectorXd& face_areas() const;

  /// The rows in use. Targets are in this order.
  const std::vector<ConstraintRow>& rows() const;
  /// For each row in use: its index in the constructor's list, or -1 - part for the centroid row of
  /// a part.
  const std::vector<int>& row_sources() const;
  /// Names of given rows that were left out because they depend on earlier ones (within 1e-9).
  const std::vector<std::string>& dropped_rows() const;
  /// The values of the rows in use at these points.
  RowTargets RowsAt(const PointsX3& points) const;

  /// @param edges    wanted edges of the frames
  /// @param targets  one for each frame, rows().size() x 3
  /// @param turns    one for each frame, or empty; rotations that are applied to the wanted edges
  /// first
  std::vector<PointsX3> Solve(const EdgeBatch& edges, const std::vector<RowTargets>& targets,
                              const std::vector<Eigen::Matrix3d>& turns = {}) const;

  /// The same, but `fill` computes the edges when they are needed, for a patch of faces and a few
  /// frames at a time.
  std::vector<PointsX3> Solve(int frames, const FillEdges& fill,
                              const std::vector<RowTargets>& targets,
                              const std::vector<Eigen::Matrix3d>& turns = {}) const;

  /// The same into buffers that are used again.
  void SolveInto(int frames, const FillEdges& fill, const std::vector<RowTargets>& targets,
                 const std::vector<Eigen::Matrix3d>& turns, FrameRows& rows,
                 std::vector<PointsX3>& poses) const;
  /// One frame by itself, in a fraction of the time that a batch of one takes. Its sums are in
  /// another order than a batch's.
  /// @param turn  of all edges
  /// @pre IsFree()
  PointsX3 SolveOne(const FillOneFrame& fill, const RowTargets& target,
                    const Eigen::Matrix3d& turn) const;

  /// Whether the parts have no rows except those of their centroids.
  bool IsFree() const;
  /// The frames of a free system before its centroids are placed: the vertex with the lowest index
  /// in each part is at the origin. Row row_of()[i] is vertex i. Neighbouring vertices have nearby
  /// rows.
  FrameRows SolveFree(int frames, const FillEdges& fill) const;
  const std::vector<int>& row_of() const;

  /// Changes `points` in place by the smallest amount, measured by this energy and under the same
  /// constraints, so that z >= floor.height. It is an active-set method: multipliers hold active
  /// vertices at the floor until no other vertex is below and none is pulled down. Exact to
  /// rounding.
  /// @return the held vertices
  /// @throws InputError  a row holds vertices below the floor, so there is no solution
  std::vector<int> LiftToFloor(PointsX3& points, const Floor& floor) const;

  /// (H + kappa M)^-1 b: smooth over distances up to 1 / sqrt(kappa), and local beyond. M is
  /// diagonal: a third of the areas of each vertex's faces, summed over the keys.
  Eigen::MatrixXd SolveScreened(const Eigen::MatrixXd& b) const;
  /// Smooth values of vertices, V x C, from values of faces, F x C: applies kappa (H + kappa M)^-1
  /// M `passes` times. Constants do not change. Each pass reduces a variation of wavelength l by
  /// the factor 1 / (1 + (2 pi screening_length / l)^2).
  Eigen::MatrixXd SmoothOverVertices(const Eigen::MatrixXd& face_values, int passes = 1) const;
  /// The displacement, changed as little as possible in the screened norm so that it keeps all
  /// exact rows (and z of `held` vertices).
  PointsX3 WithoutRows(PointsX3 displacement, const std::vector<int>& held = {}) const;
  /// Screening length, 1 / sqrt(kappa).
  double screening_length() const;

 private:
  struct Impl;
  class FloorSearch;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
