// Decimation by half-edge collapses: vertices are removed, and the others do not move.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// A sum of weighted squared distances to planes, as a quadric x^T A x + 2 b x + c. Holds the upper
/// triangle of the symmetric 4 x 4 matrix by rows.
struct Quadric {
  std::array<double, 10> q{};
  void AddPlane(const Eigen::Vector3d& normal, double offset, double weight);
  void Add(const Quadric& other);
  double At(const Eigen::Vector3d& x) const;
};

/// A mesh that is being decimated.
struct DecimatedMesh {
  std::vector<int> vertex;  ///< V, the input mesh's vertex of each; ascending
  PointsX3 points;          ///< V x 3
  std::vector<std::array<int, 3>> faces;
  std::vector<Quadric> quadrics;  ///< V, of all faces around the vertex and around those that
                                  ///< collapsed into it, weighted by twice the area
};
/// The input as a DecimatedMesh. Faces with a repeated vertex are left out.
DecimatedMesh ToDecimatedMesh(const PointsX3& points, const FacesX3& faces);

/// Decimates a mesh by one collapse at a time, the cheapest first.
class HalfEdgeDecimator {
 public:
  /// @param parent  for each vertex of the input, the vertex that it collapsed into, or itself;
  /// updated during decimation
  HalfEdgeDecimator(DecimatedMesh mesh, std::vector<int>& parent);
  ~HalfEdgeDecimator();
  /// Collapses until `count` vertices are left or no collapse is allowed. Returns the number of
  /// vertices left.
  int DecimateTo(int count);
  DecimatedMesh Rest() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The same in rounds, for large meshes. In each round, vertices from the cheaper half collapse,
/// the cheapest first, if they do not touch another collapse. This is a few times faster, because
/// it needs no queue and accesses memory in order. It stops at `count` vertices, or when almost no
/// collapse is allowed.
/// Same bits for any thread count.
void DecimateInRounds(DecimatedMesh& mesh, int count, std::vector<int>& parent);

}  // namespace keypose
