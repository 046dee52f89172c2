#include "cleanup/editing/decimate.h"

#include <gtest/gtest.h>

#include "cleanup/testing/damaged_meshes.h"
#include "core/numbers/parallel.h"

namespace keypose::cleanup::decimate_test {

TEST(Decimated, SameBitsForAnyThreadCount) {
  const Mesh mesh = MakeFigure(3, 3);
  SetThreadCount(1);
  const Mesh one = Decimated(mesh, 500);
  SetThreadCount(3);
  const Mesh three = Decimated(mesh, 500);
  SetThreadCount(0);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.faces, three.faces);
}

}  // namespace keypose::cleanup::decimate_test
