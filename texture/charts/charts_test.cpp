#include "texture/charts/charts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/surfaces/shapes.h"

namespace keypose::texture::charts_test {

TEST(MakeChart, RingIsNoDiskAndPinchedVertexCountsTwice) {
  const Mesh tube = MakeCylinder(0.5, 1, 16, 4);
  const Surface surface = MakeSurface(tube);
  std::vector<int> side;
  for (int f = 0; f < tube.face_count(); ++f)
    if (std::abs(surface.normals(f, 2)) < 0.1) side.push_back(f);
  EXPECT_FALSE(MakeChart(surface, side).disk);
  // Two faces that share only a vertex: six local vertices, not connected.
  const int v = tube.faces(side[0], 0);
  for (const int f : side) {
    int shared = 0;
    for (int k = 0; k < 3; ++k)
      shared += (tube.faces.row(side[0]).array() == tube.faces(f, k)).any();
    if (shared != 1 || !(tube.faces.row(f).array() == v).any()) continue;
    const Chart pinched = MakeChart(surface, {side[0], f});
    EXPECT_EQ(pinched.vertices.size(), 6u);
    EXPECT_FALSE(pinched.disk);
    return;
  }
  FAIL() << "the tube has no such pair";
}

}  // namespace keypose::texture::charts_test
