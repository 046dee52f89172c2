// Coloured point clouds of two halves of a figure, and what bringing them together needs.
#pragma once

#include <Eigen/Core>
#include <utility>

#include "core/camera.h"
#include "core/kd_tree.h"

namespace keypose::reconstruct {

/// Points with the shares that red, green and blue have in their colour.
struct Cloud {
  PointsX3 points, colors;
  Eigen::Index size() const { return points.rows(); }
};

/// At most `count` of a scene's points, evenly through their list, without those far from all
/// others.
Cloud Decimated(const Scene& scene, int count);

/// Root mean square distance from the middle.
double Spread(const PointsX3& points);

/// Median distance of a point to its nearest neighbour: finer than this a cloud tells no place.
double Spacing(const Cloud& cloud, const KdTree& tree);

/// Turns spread evenly over all there are: a spiral on the unit quaternions.
/// Source: Alexa, "Super-Fibonacci spirals", CVPR 2022.
Eigen::Matrix3d Turn(int i, int count);

/// Share of the second cloud's points that have one of the first beside them, of their colour; and
/// the rms of these.
std::pair<double, double> Agreement(const Cloud& first, const KdTree& tree, const Cloud& second,
                                    const Similarity3& first_from_second, double limit,
                                    double max_color);

/// Point-to-plane steps over pairs that agree: sparse points of two halves are never the same ones,
/// but lie on one surface.
/// Source: Chen & Medioni, "Object modelling by registration of multiple range images", 1992.
void Polish(const Cloud& first, const KdTree& tree, const Cloud& second, double limit,
            double max_color, bool with_scale, Similarity3& first_from_second);

/// Between the rotations of two motions [rad].
double AngleBetween(const Similarity3& a, const Similarity3& b);

}  // namespace keypose::reconstruct
