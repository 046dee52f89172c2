#include "motion/tracking/body_outline.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::body_outline_test {

TEST(VisitSpans, AreTheCellsWhoseCentresTheFacesCover) {
  const BodyShape shape = AverageShape();
  const LocalSurface surface = SurfaceOf(shape);
  const PosedBody body = Posed(Standing(), shape);
  const std::vector<Silhouette> silhouettes = Filmed(Ring(2), shape, Standing());
  for (const Silhouette& silhouette : silhouettes) {
    const SegmentRaster raster = MakeRaster(silhouette);
    const ProjectedBody projected = Project(silhouette, surface, body);
    for (int s = 0; s < kSegments; ++s) {
      std::vector<char> covered(raster.bits.size(), 0), drawn = covered;
      for (const auto& t : internal::Drawn(Detail::kFine).triangles) {
        std::array<Eigen::Vector2d, 3> c;
        for (int i = 0; i < 3; ++i)
          c[i] = raster.CellOf(projected.pixels.row(s * kSegmentVertices + t[i]).transpose());
        for (int y = 0; y < raster.height; ++y)
          for (int x = 0; x < raster.width; ++x) {
            bool inside = true;
            for (int i = 0; i < 3; ++i) {
              const Eigen::Vector2d side = c[(i + 1) % 3] - c[i], to = Eigen::Vector2d(x, y) - c[i];
              inside = inside && side.x() * to.y() - side.y() * to.x() < 0;
            }
            if (inside) covered[static_cast<std::size_t>(y) * raster.width + x] = 1;
          }
      }
      VisitSpans(raster, projected, s, Detail::kFine, [&](int first, int end) {
        std::fill(drawn.begin() + first, drawn.begin() + end, 1);
      });
      EXPECT_GT(std::count(drawn.begin(), drawn.end(), 1), 10) << s;
      EXPECT_EQ(drawn, covered) << s;
    }
  }
}

}  // namespace keypose::motion::body_outline_test
