#include "texture/charts/parametrise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/surfaces/shapes.h"
#include "texture/charts/charts.h"

namespace keypose::texture::parametrise_test {

TEST(Stretches, RotationHasNone) {
  const Eigen::Vector2d s = Stretches({0, 0, 1}, {2, 0, 1}, {1, 3, 1}, {0, 0}, {0, 2}, {-3, 1});
  EXPECT_NEAR(s[0], 1, 1e-12);
  EXPECT_NEAR(s[1], 1, 1e-12);
}

TEST(Flattened, DevelopableStripBecomesItsOwnPlan) {
  const Mesh tube = MakeCylinder(0.5, 1, 32, 8);
  const Surface surface = MakeSurface(tube);
  std::vector<int> faces;  // a third of the way round the side
  for (int f = 0; f < tube.face_count(); ++f)
    if (std::abs(surface.normals(f, 2)) < 0.1 && surface.centers(f, 0) > 0.25) faces.push_back(f);
  const Chart chart = MakeChart(surface, faces);
  ASSERT_TRUE(chart.disk);
  const auto uvs = Flattened(surface, chart, 200);
  ASSERT_TRUE(uvs.has_value());
  EXPECT_LT(MeasureDistortion(surface, chart, *uvs).max, 1.001);
}

}  // namespace keypose::texture::parametrise_test
