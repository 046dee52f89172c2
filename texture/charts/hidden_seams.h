// Where seams are least visible on a figure, and chart borders that move there.
#pragma once

#include <vector>

#include "texture/charts/charts.h"

namespace keypose::texture {

/// The distribution of viewing directions: from all round and from above, more often from the front
/// than from the back, seldom from below.
struct Viewers {
  Eigen::Vector3d up = {0, 0, 1};
  Eigen::Vector3d front = {0, -1, 0};  ///< towards the viewer in front
};

/// Visibility of a surface.
struct Exposure {
  /// per vertex in [0,1]: share of the viewers that see it, weighted by their frequency and the
  /// cosine; 1: faces most viewers and is not occluded
  Eigen::VectorXd seen;
  /// per vertex, > 0: cost of a seam per length: low in creases, below, behind
  Eigen::VectorXd cost;
  std::vector<char> front;  ///< per vertex: 1 where a viewer in front sees it well (at most 60
                            ///< degrees from its normal, not occluded)
};
/// Casts some 30 rays per vertex.
/// Same bits for any thread count.
Exposure FindExposure(const Surface& surface, const Viewers& viewers);

/// Cost of a seam along edge k of each face: length times the mean cost of its ends. F x 3.
PointsX3 SeamCosts(const Surface& surface, const Eigen::VectorXd& cost);

/// Computes the border between two neighbouring charts again: the cheapest one within a band around
/// the present border. Borders to other charts stay.
/// @param label  chart of each face
/// @param band   largest move of the border in rings of faces
/// @return faces that change sides; empty if the present border is the best
/// Source: minimal cuts as in Kwatra et al., SIGGRAPH 2003, on the dual graph of the surface.
std::vector<int> BetterBorder(const Surface& surface, const PointsX3& costs,
                              const std::vector<int>& label, int a, int b, int band);

}  // namespace keypose::texture
