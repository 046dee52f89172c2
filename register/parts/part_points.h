// What fitting a loose part to its seat and to its counterpart have in common.
#pragma once

#include <algorithm>
#include <iterator>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::registration {

inline constexpr int kFeet = 96;  ///< most vertices of a part that are compared with others

/// Every n-th of the vertices: `most` of them, up to twice as many of few.
inline std::vector<int> SomeOf(const std::vector<int>& all, int most) {
  std::vector<int> some;
  const std::size_t stride = std::max<std::size_t>(1, all.size() / static_cast<std::size_t>(most));
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  return some;
}

inline PointsX3 RowsOf(const PointsX3& points, const std::vector<int>& rows) {
  PointsX3 some(std::ssize(rows), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) some.row(i) = points.row(rows[i]);
  return some;
}

/// Moves the vertices.
inline void Apply(const Similarity3& motion, const std::vector<int>& vertices, PointsX3& points) {
  for (int v : vertices) points.row(v) = (motion * points.row(v).transpose().eval()).transpose();
}

}  // namespace keypose::registration
