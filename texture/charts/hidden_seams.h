// Where on a figure seams are least seen, and chart borders that move there.
#pragma once

#include <vector>

#include "texture/charts/charts.h"

namespace keypose::texture {

/// Where people look from: all round and from above, the front more than the back, seldom from
/// below.
struct Viewers {
  Eigen::Vector3d up = {0, 0, 1};
  Eigen::Vector3d front = {0, -1, 0};  ///< towards the viewer in front
};

/// What can be seen of a surface.
struct Exposure {
  Eigen::VectorXd seen;     ///< per vertex in [0,1]: share of the viewers that see it, by their
                            ///< likelihood and the cosine; 1: turned to most and free
  Eigen::VectorXd cost;     ///< per vertex, > 0: what a seam costs there for its length: little in
                            ///< creases, below, behind
  std::vector<char> front;  ///< per vertex: 1 where a viewer in front sees it well (60 degrees at
                            ///< most from its normal, nothing between)
};
/// Casts some 30 rays a vertex.
/// Same bits for any thread count.
Exposure FindExposure(const Surface& surface, const Viewers& viewers);

/// Cost of a seam along edge k of each face: length times the mean cost of its ends. F x 3.
PointsX3 SeamCosts(const Surface& surface, const Eigen::VectorXd& cost);

/// Faces of two neighbouring charts anew: the border between them becomes the cheapest one within a
/// band about the present border. Borders to other charts stay.
/// @param label  chart of each face
/// @param band   how many rings of faces the border may move
/// @return faces that change sides; empty when the present border is the best
/// Source: minimal cuts as in Kwatra et al., SIGGRAPH 2003, on the dual graph of the surface.
std::vector<int> BetterBorder(const Surface& surface, const PointsX3& costs,
                              const std::vector<int>& label, int a, int b, int band);

}  // namespace keypose::texture
