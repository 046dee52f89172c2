#include "synth/worlds/outer_surface.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::synth::outer_surface_test {

TEST(OuterSurface, OverlappingBallsBecomeTheirUnion) {
  Mesh two = MakeIcosphere(4);
  two.points *= 0.05;
  const Mesh one = two;
  two.points.resize(2 * one.points.rows(), 3);
  two.faces.resize(2 * one.faces.rows(), 3);
  two.points << one.points, one.points.rowwise() + Eigen::RowVector3d(0.06, 0, 0);
  two.faces << one.faces, (one.faces.array() + static_cast<int>(one.points.rows())).matrix();
  const Mesh outer = OuterSurface(two, 0.004);
  EXPECT_TRUE(CheckClosed(outer).closed());
  EXPECT_EQ(CheckClosed(outer).components, 1);
  EXPECT_EQ(Genus(outer), 0);
  const double r = 0.05, cap = r - 0.03,
               lens = 2 * 3.141592653589793 * cap * cap * (3 * r - cap) / 3;
  const double whole = 2 * SignedVolume(one.points, one.faces) - lens;
  EXPECT_NEAR(CheckClosed(outer).volume / whole, 1,
              0.01);  // chords of 2 mm, and the seam's crevice of 4 mm closed
}

}  // namespace keypose::synth::outer_surface_test
