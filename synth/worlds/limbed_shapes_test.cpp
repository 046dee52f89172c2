#include "synth/worlds/limbed_shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/numbers/kd_tree.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth::limbed_shapes_test {

using Eigen::Vector3d;

// A coarse sample of the solid's surface in the rest pose.
PointsX3 RestSample(const Clay& clay) {
  Vector3d low, high;
  clay.Bounds(&low, &high);
  return Polygonize([&](const Vector3d& x) { return clay.Distance(x); }, low, high, 0.008).points;
}

TEST(LimbedShape, PosesAreOneToOneForAllSeedsAndAngles) {
  for (const char* shape : {"tentacle", "character"})
    for (std::uint64_t seed = 0; seed < (shape == std::string("tentacle") ? 40 : 10); ++seed) {
      LimbedShapeOptions options;
      options.seed = seed;
      options.shape = shape;
      const PointsX3 rest = RestSample(MakeLimbedShape(options).clay);
      for (const double bend_deg : {90.0, 270.0}) {
        options.bend_deg = bend_deg;
        const LimbedShape thing = MakeLimbedShape(options);
        const PointsX3 posed = thing.pose(rest);
        const KdTree tree(posed);
        for (Eigen::Index i = 0; i < rest.rows(); ++i) {
          ASSERT_GT(thing.pose.Jacobian(rest.row(i)).determinant(), 0.2)
              << shape << seed << " bent by " << bend_deg;
          for (const auto& other : tree.Nearest(Vector3d(posed.row(i)), 24))
            ASSERT_FALSE(other.squared_distance < 0.007 * 0.007 &&
                         (rest.row(i) - rest.row(other.index)).norm() > 0.05)
                << shape << seed << " touches itself at " << bend_deg;
        }
      }
    }
}

TEST(LimbedShape, NothingOfTheSolidLiesWhereALimbsHoldFades) {
  // Otherwise the bend would shear the part: the truth would be smooth, but not a bend.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    LimbedShapeOptions options;
    options.seed = seed;
    options.shape = "character";
    options.bend_deg = 100;
    const LimbedShape thing = MakeLimbedShape(options);
    const PointsX3 rest = RestSample(thing.clay);
    for (const Deformation& step : thing.pose.steps)
      for (Eigen::Index i = 0; i < rest.rows(); ++i) {
        const Vector3d x = rest.row(i);
        if ((x - step.origin).dot(step.axis) <= step.begin) continue;
        const double weight = step.Weight(x);
        ASSERT_TRUE(weight == 0 || weight == 1)
            << "seed " << seed << " weight " << weight << " at " << x.transpose();
      }
  }
}

}  // namespace keypose::synth::limbed_shapes_test
