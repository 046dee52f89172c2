// Distances along a small mesh, spread samples, and the ends of limbs.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"

namespace keypose {

/// Edges of a mesh plus the straight way across each edge between its two opposite corners,
/// unfolded; shortest ways over it overestimate true geodesics by a few percent. Pieces that do not
/// touch are joined by their closest vertices, so that every distance is finite.
class GeodesicGraph {
 public:
  enum Ways { kEdgesOnly, kUnfolded };  ///< kEdgesOnly: faster, distances up to 15 % too long
  /// @throws InputError  no vertices
  GeodesicGraph(const PointsX3& points, const FacesX3& faces, Ways ways = kUnfolded);
  int size() const { return static_cast<int>(offset_.size()) - 1; }
  /// Distance of every vertex to the nearest source; `nearest`, when given, becomes the index into
  /// `sources` of that one.
  Eigen::VectorXd From(const std::vector<int>& sources, std::vector<int>* nearest = nullptr) const;
  /// S x V, one row a source.
  /// Same bits for any thread count.
  Eigen::MatrixXd Rows(const std::vector<int>& sources) const;
  /// `count` vertices, each the farthest from those before it, starting with `given` (which are
  /// kept) or with a vertex at an end.
  std::vector<int> FarthestPoints(int count, std::vector<int> given = {}) const;
  /// Neighbours over edges of the mesh proper.
  const std::vector<std::vector<int>>& neighbors() const { return neighbors_; }

 private:
  struct Way {
    double length;
    int to;
  };
  /// Lowers `distance` along all ways from the seeds (whose distance is set), and where given takes
  /// over the index of the nearest source.
  void Spread(const std::vector<int>& seeds, Eigen::VectorXd& distance,
              std::vector<int>* nearest) const;

  std::vector<int> offset_;
  std::vector<Way> ways_;
  double steps_per_length_ = 0;  ///< of the queue of a search
  std::vector<std::vector<int>> neighbors_;
};

/// A local maximum of a field, and by how much the field falls on the best way to a higher one (its
/// own height for the highest).
struct Peak {
  int vertex = -1;
  double persistence = 0;
};
/// Peaks of the field over the mesh's edges, most persistent first. Deterministic (ties by index).
std::vector<Peak> FindPeaks(const std::vector<std::vector<int>>& neighbors,
                            const Eigen::VectorXd& field);

}  // namespace keypose
