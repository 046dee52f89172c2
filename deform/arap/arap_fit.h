// As-rigid-as-possible fitting: deforms a mesh to weighted goals while it keeps its shape locally.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <utility>
#include <vector>

#include "core/numbers/cholesky.h"
#include "core/values/mesh.h"
#include "deform/arap/rigid_pieces.h"

namespace keypose {

/// Quadratic energies that pull vertices to points and planes: p^T Q p - 2 b^T p for each vertex.
struct Pulls {
  std::vector<Eigen::Matrix3d> q;  ///< V, symmetric, positive semidefinite
  PointsX3 b;                      ///< V x 3

  explicit Pulls(Eigen::Index vertices);
  void AddPoint(Eigen::Index vertex, double weight, const Eigen::Vector3d& goal);
  /// Adds weight (normal . (p - goal))^2; `normal` must have unit length.
  void AddPlane(Eigen::Index vertex, double weight, const Eigen::Vector3d& normal,
                const Eigen::Vector3d& goal);
  Eigen::VectorXd MeanWeights() const;  ///< V, a third of the trace of each q
};

/// Minimises, alternately over the maps A (local) and the positions p (global),
///
///     E(p, A) = 1/2 sum_i sum_{j~i} c_ij |(p_i - p_j) - A_i (v_i - v_j)|^2
///             + kappa/2 sum_{i~j} c_ij |A_i - A_j|^2
///             + rigidity/2 sum_i s_i |A_i - R(A_i)|^2 + pulls(p).
///
/// c_ij are half the sums of the rest mesh's cotangents, clamped to [1e-3, 20], times the stiffness
/// of the edge. s_i is half the trace of the fan's second moments. With infinite rigidity the maps
/// are rotations (as rigid as possible). With low rigidity they are affine maps that vary smoothly,
/// so a limb may squash or stretch evenly. The global system V x V is analysed once.
/// Source: Sorkine and Alexa, SGP 2007; the smoothness term: Levi and Gotsman, TVCG 2015, who use
/// it for rotations.
/// Same bits for any thread count. Two threads must not use one object at once.
class ArapFit {
 public:
  /// @param rest       V x 3
  /// @param stiffness  V or empty; factor on c (geometric mean of an edge's ends) and on the
  ///                   rigidity; see RigidPieces for very stiff vertices, which form rigid pieces
  /// @param smoothing  kappa [length^2]: maps vary little over distances below sqrt(kappa)
  /// @param factor  whether the system is factored; a large mesh that starts from a coarser level's
  /// result needs no factor
  ArapFit(const PointsX3& rest, const FacesX3& faces, const Eigen::VectorXd& stiffness,
          double smoothing, bool factor = true);

  bool rigid() const { return rigidity_ >= kRigid; }
  void SetRigidity(double rigidity);  ///< above 0; from 1e6 on, infinite
  /// Prepares the solver for pulls with about these mean weights (V, each >= 0). A connected part
  /// without pulls gets a weight of 1e-7.
  /// @throws SolverError
  void SetWeights(const Eigen::VectorXd& weights);
  /// Computes the best map of each vertex's fan from rest to `moved`, close to the previous maps of
  /// its neighbours.
  void FitMaps(const PointsX3& moved);
  /// Positions that minimise the shape term plus the pulls, by at most `steps` conjugate gradient
  /// steps from `start`. The preconditioner is the factor of the last SetWeights. Without a factor
  /// it is the blocks on the diagonal, with up to three times as many steps.
  PointsX3 FitPositions(const Pulls& pulls, const PointsX3& start, int steps) const;

  const std::vector<Eigen::Matrix3d>& maps() const { return maps_; }
  void SetMaps(std::vector<Eigen::Matrix3d> maps) { maps_ = std::move(maps); }
  const Eigen::VectorXd& vertex_areas() const {
    return areas_;
  }  ///< V, a third of the incident faces' areas [length^2]
  /// The shape term of each vertex over the size of its fan: 0 when the fan moved exactly as its
  /// map, else about the squared strain.
  /// @return V
  Eigen::VectorXd Strain(const PointsX3& moved) const;
  /// The factor on the rest shape that fits `moved` best under the current maps.
  double BestScale(const PointsX3& moved) const;
  void ScaleRest(double factor);  ///< scales the rest shape
  /// The shape term as p^T L p - 2 p^T ShapePull(), with the maps as they are, for solvers with
  /// further unknowns.
  /// @return L, V x V; only its lower triangle is stored
  const Eigen::SparseMatrix<double>& shape_matrix() const { return lower_; }
  PointsX3 ShapePull() const;  ///< V x 3
  const RigidPieces& pieces() const { return pieces_; }
  /// Moves the rigid pieces' vertices to their exact shape. Returns the factor on the rest shape
  /// that fits them best.
  double StraightenPieces(PointsX3& moved) const { return pieces_.Straighten(rest_, moved); }

 private:
  static constexpr double kRigid = 1e6;
  void BuildEdges(const FacesX3& faces, const Eigen::VectorXd& stiffness);
  void BuildMatrix();
  void BuildFans();
  void InvertMoments();
  void AddShapePull(Eigen::MatrixXd& b) const;
  Eigen::VectorXd Rings() const;  ///< V, sums of c_ij
  Eigen::MatrixXd Apply(const Eigen::MatrixXd& p, const Pulls& pulls) const;
  double Hold(int i) const;  ///< weight of the rigidity at a vertex
  Eigen::Matrix3d FanMap(const PointsX3& moved, int i) const;

  PointsX3 rest_;
  double smoothing_, rigidity_ = 1e300;
  bool factored_;
  Eigen::VectorXd areas_;
  Eigen::VectorXd stiffness_;  // or empty
  RigidPieces pieces_;
  // the neighbours of vertex i: neighbour_[offset_[i] .. offset_[i+1])
  std::vector<int> offset_, neighbour_;
  std::vector<double> weight_;
  std::vector<Eigen::Vector3d> edge_;     // of the rest shape, from each neighbour to the vertex
  std::vector<Eigen::Matrix3d> moments_;  // sum_j c_ij e e^T, and in its diagonal kappa sum_j c_ij
  std::vector<double> size_;              // half the trace of the first
  std::vector<Eigen::Matrix3d> inverse_;  // of the moments with the rigidity; empty until general
                                          // (not rotation) maps are fitted
  std::vector<int> component_;
  int components_ = 0;
  Eigen::SparseMatrix<double> lower_, system_;
  std::vector<int> diagonal_;
  SparseCholesky factor_;
  Eigen::VectorXd hold_;
  std::vector<Eigen::Matrix3d> maps_, previous_;
};

/// The rotation nearest to m (det > 0 always). Uses a polynomial of m with a root found by Newton's
/// method, or a singular value decomposition for degenerate m.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& m);

}  // namespace keypose
