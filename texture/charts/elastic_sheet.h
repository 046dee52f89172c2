// A chart as an elastic sheet that resists deformation within its plane; flattening and packing
// both relax it.
#pragma once

#include <array>
#include <vector>

#include "core/numbers/cholesky.h"
#include "texture/charts/charts.h"

namespace keypose::texture {

/// Triangle in its own plane: corner 0 in the origin, corner 1 on the x axis, corner 2 above it.
struct RestTriangle {
  double x1, x2, y2;
};
RestTriangle RestOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// The shape of a chart without stress.
struct RestShape {
  std::vector<RestTriangle> triangles;  ///< per face
  /// opposite of edge k (corners k, k + 1), kept in [1e-2, 1e2]
  std::vector<std::array<double, 3>> cotangents;
  double area = 0;
};
RestShape RestShapeOf(const Surface& surface, const Chart& chart);

/// Cotangent Laplacian, lower triangle, of the vertices with column[v] >= 0.
Eigen::SparseMatrix<double> ChartLaplacian(const Chart& chart, const RestShape& rest,
                                           const std::vector<int>& column, int size);

double SignedArea(const UvsX2& uvs, const Chart& chart, int face);
/// Whether each face is counter-clockwise with more than `least` times its area in space times
/// scale^2.
bool Upright(const Surface& surface, const Chart& chart, const UvsX2& uvs, double least,
             double scale = 1);

/// One factorisation for many rounds of as-rigid-as-possible relaxation.
class Sheet {
 public:
  /// @param chart  a disk; must outlive the sheet
  /// @param hold   >= 0: weight of the boundary vertices' targets, relative to springs of about 1;
  /// 0: no targets, and vertex 0 is fixed
  Sheet(const Surface& surface, const Chart& chart, double hold);

  /// One round: the best rotation of each triangle, then a solve for all vertices. `targets`: one
  /// row per boundary vertex, unused when hold is 0.
  /// @return displacement of the vertices over their norm
  /// Source: Liu et al., SGP 2008.
  double Settle(double scale, const UvsX2& targets, UvsX2& uvs) const;
  const RestShape& rest() const { return rest_; }

 private:
  const Chart& chart_;
  RestShape rest_;
  double hold_;
  SparseCholesky solver_;
};

}  // namespace keypose::texture
