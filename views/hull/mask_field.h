// Signed distance to a mask's border, for any point of the picture: how far inside or outside of
// the figure's outline a point projects.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "views/prepared/prepared_view.h"

namespace keypose {

struct MaskField {
  Eigen::Matrix<double, 3, 4> from_world;  ///< to homogeneous pixels of the field
  double focal = 0;
  int width = 0, height = 0;
  std::vector<float> distance;  ///< pixels of the field's level; positive outside, 0 midway between
                                ///< the last pixel inside and the first outside
  std::array<bool, 4> edges = {};  ///< whether the mask touches the photograph's left, right, top,
                                   ///< bottom side: beyond it nothing is known

  float At(int x, int y) const { return distance[static_cast<std::size_t>(y) * width + x]; }
};

/// Of one level of a view's pyramid.
/// Cost: linear in the pixels.
/// Source: Felzenszwalb & Huttenlocher, Theory of Computing 2012.
MaskField MakeMaskField(const PreparedView& view, int level);

}  // namespace keypose
