// Harmonic fields of a surface that have given values at the marked triangles.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::motion {

/// Sparse rows of weights: what share each mark has in the value of a vertex or a face.
struct WeightRows {
  std::vector<int> begin{0};  ///< rows + 1
  std::vector<int> mark;
  std::vector<double> weight;

  int rows() const { return static_cast<int>(begin.size()) - 1; }
  void Append(const std::vector<std::pair<int, double>>& row);
};

struct MarkFieldOptions {
  /// Negative cotangents are raised to a small positive weight, so that no field leaves the range
  /// of the marks' values. False: the plain cotangent Laplacian, as in the paper.
  bool bounded = true;
  double least_weight = 1e-13;  ///< weights below are dropped, and the others made to sum to 1
};

/// Solves the Laplace equation once for each mark, with 1 at the three corners of its triangle and
/// 0 at those of the others. Any field is then a weighted sum of its values at the marks. A vertex
/// that several marks share gets their mean. A marked face has the values of its own marks alone;
/// any other face has the mean of its corners. A connected part without marks takes, as a whole,
/// the weights of the nearest vertex of a part with marks.
/// Cost: one sparse factor, one solve for each mark. Same bits for any thread count.
/// Source: the harmonic fields of the paper's Section 4 (after Zayer et al. 2005); as a basis
/// because the marks do not change from frame to frame.
class MarkFields {
 public:
  /// @param marked_faces  M faces of the mesh, which may repeat; each has an area
  /// @throws InputError  no marked faces, or a face that the mesh does not have
  /// @throws SolverError
  MarkFields(const PointsX3& points, const FacesX3& faces, const std::vector<int>& marked_faces,
             const MarkFieldOptions& options = {});

  int marks() const { return marks_; }
  const WeightRows& vertices() const { return vertices_; }
  /// For each face: its row of own_rows() if it is marked, else -1.
  const std::vector<int>& own_row() const { return own_row_; }
  const WeightRows& own_rows() const { return own_rows_; }
  /// The lowest weight before rows were made to sum to 1: below -1e-3 the triangulation is poor.
  double least_weight() const { return least_; }
  /// Parts without a mark, which move with the nearest part that has one.
  int unmarked_parts() const { return unmarked_parts_; }

 private:
  int marks_ = 0, unmarked_parts_ = 0;
  double least_ = 0;
  WeightRows vertices_, own_rows_;
  std::vector<int> own_row_;
};

/// Half the cotangents of a triangle's corners 0, 1, 2, that is the weights of the opposite edges;
/// those of a small equilateral triangle where it has no area.
Eigen::Vector3d HalfCotangents(const PointsX3& points, const FacesX3& faces, Eigen::Index face);

}  // namespace keypose::motion
