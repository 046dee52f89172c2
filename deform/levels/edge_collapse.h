// Half-edge collapses: a mesh loses vertices and keeps the places of the others.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/mesh.h"

namespace keypose {

/// Symmetric quadric x^T A x + 2 b x + c, upper triangle of its 4 x 4 matrix by rows: weighted
/// squared distances to planes.
struct Quadric {
  std::array<double, 10> q{};
  void AddPlane(const Eigen::Vector3d& normal, double offset, double weight);
  void Add(const Quadric& other);
  double At(const Eigen::Vector3d& x) const;
};

/// A mesh that is being decimated.
struct DecimatedMesh {
  std::vector<int> vertex;  ///< V, the vertex of the input mesh that each one is; rising
  PointsX3 points;          ///< V x 3
  std::vector<std::array<int, 3>> faces;
  std::vector<Quadric> quadrics;  ///< V, of all faces around and around what collapsed into it,
                                  ///< weighted by doubled area
};
/// The input as it is; faces with a corner twice are left out.
DecimatedMesh ToDecimatedMesh(const PointsX3& points, const FacesX3& faces);

/// Decimates a mesh one collapse at a time, the cheapest first.
class HalfEdgeDecimator {
 public:
  /// @param parent  of each vertex of the input, itself while it lives, then the one into which it
  /// collapsed; written to while decimation
  HalfEdgeDecimator(DecimatedMesh mesh, std::vector<int>& parent);
  ~HalfEdgeDecimator();
  /// Collapses until `count` vertices are left or no collapse is allowed; returns how many are
  /// left.
  int DecimateTo(int count);
  DecimatedMesh Rest() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The same in rounds, for large meshes: in each, the cheaper half of the vertices collapse as far
/// as no two of them touch, cheapest first. A few times faster, as it needs no queue and runs
/// through memory in order. It stops at `count` vertices, or when next to nothing may collapse.
/// Same bits for any thread count.
void DecimateInRounds(DecimatedMesh& mesh, int count, std::vector<int>& parent);

}  // namespace keypose
