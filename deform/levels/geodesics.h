// Geodesic distances on a small mesh, evenly distributed samples, and the ends of limbs.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/size_of.h"

namespace keypose {

/// A graph of the mesh's edges and, across each edge, the straight line between the two opposite
/// corners in the unfolded plane. Its shortest paths overestimate geodesic distances by a few
/// percent. Separate pieces are joined at their closest vertices, so all distances are finite.
class GeodesicGraph {
 public:
  enum Ways { kEdgesOnly, kUnfolded };  ///< kEdgesOnly: faster, distances are up to 15 % too long
  /// @throws InputError  no vertices
  GeodesicGraph(const PointsX3& points, const FacesX3& faces, Ways ways = kUnfolded);
  int size() const { return SizeOf(offset_) - 1; }
  /// The distance of each vertex from the nearest source. `nearest`, if given, receives the index
  /// of that source in `sources`.
  Eigen::VectorXd From(const std::vector<int>& sources, std::vector<int>* nearest = nullptr) const;
  /// Distances of all vertices from each source, S x V.
  /// Same bits for any thread count.
  Eigen::MatrixXd Rows(const std::vector<int>& sources) const;
  /// `count` vertices, each the farthest from those before it. Starts with `given`, or with a
  /// vertex at the end of a limb.
  std::vector<int> FarthestPoints(int count, std::vector<int> given = {}) const;
  /// Neighbours of each vertex by edges of the mesh.
  const std::vector<std::vector<int>>& neighbors() const { return neighbors_; }

 private:
  struct Way {
    double length;
    int to;
  };
  /// Lowers `distance` along all paths from the seeds, whose distance is set. If `nearest` is
  /// given, the index of the nearest source is passed on as well.
  void Spread(const std::vector<int>& seeds, Eigen::VectorXd& distance,
              std::vector<int>* nearest) const;

  std::vector<int> offset_;
  std::vector<Way> ways_;
  double steps_per_length_ = 0;  ///< of a search's queue
  std::vector<std::vector<int>> neighbors_;
};

/// A local maximum of a field. Its persistence is the least drop of the field on a path to a higher
/// maximum; for the highest one of a connected part it is its height above the field's minimum.
struct Peak {
  int vertex = -1;
  double persistence = 0;
};
/// The local maxima of a field on the mesh's edge graph, the most persistent first. Deterministic
/// (ties by index).
std::vector<Peak> FindPeaks(const std::vector<std::vector<int>>& neighbors,
                            const Eigen::VectorXd& field);

}  // namespace keypose
