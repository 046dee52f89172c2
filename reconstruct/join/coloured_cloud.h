// Coloured point clouds of a figure's two models, and operations to align them.
#pragma once

#include <Eigen/Core>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/values/camera.h"

namespace keypose::reconstruct {

/// Points with chromaticities: the shares of red, green and blue in their colours.
struct Cloud {
  PointsX3 points, colors;
  Eigen::Index size() const { return points.rows(); }
};

/// At most `count` of a scene's points, evenly spread over the list, without outliers.
Cloud Decimated(const Scene& scene, int count);

/// Root mean square distance from the centroid.
double Spread(const PointsX3& points);

/// Median distance of a point to its nearest neighbour: the resolution of the cloud.
double Spacing(const Cloud& cloud, const KdTree& tree);

/// Rotations evenly distributed over SO(3): a spiral on the unit quaternions.
/// Source: Alexa, "Super-Fibonacci spirals", CVPR 2022.
Eigen::Matrix3d Turn(int i, int count);

/// Share of the second cloud's points with a point of the first nearby and of the same colour, and
/// the rms distance of these pairs.
std::pair<double, double> Agreement(const Cloud& first, const KdTree& tree, const Cloud& second,
                                    const Similarity3& first_from_second, double limit,
                                    double max_color);

/// Point-to-plane steps over pairs that agree, because sparse points of two models are never the
/// same points, but lie on one surface.
/// Source: Chen & Medioni, "Object modelling by registration of multiple range images", 1992.
void Polish(const Cloud& first, const KdTree& tree, const Cloud& second, double limit,
            double max_color, bool with_scale, Similarity3& first_from_second);

/// Angle between the rotations of two motions [rad].
double AngleBetween(const Similarity3& a, const Similarity3& b);

}  // namespace keypose::reconstruct
