#include "texture/packing/elastic_packing.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/surfaces/shapes.h"
#include "texture/charts/parametrise.h"
#include "texture/packing/contact.h"
#include "texture/packing/nesting.h"
#include "texture/packing/packing.h"
#include "texture/packing/testing/outlines.h"

namespace keypose::texture::elastic_packing_test {

TEST(SetApart, OverlappingSquaresEndWithTheGapBetweenThem) {
  const std::vector<UvsX2> squares = {Rectangle(0, 0, 1, 1), Rectangle(0, 0, 1, 1)};
  Nesting nesting;
  nesting.scale = 0.3;
  nesting.places = {{0, {0.1, 0.3}}, {0.1, {0.395, 0.3}}};
  const auto apart = SetApart(squares, nesting, 0.01);
  ASSERT_TRUE(apart.has_value());
  EXPECT_GT(apart->scale, 0.27);
  const std::vector<UvsX2> rims = {Placed(squares[0], apart->scale, apart->places[0]),
                                   Placed(squares[1], apart->scale, apart->places[1])};
  EXPECT_GE(FindContacts(rims, 0.01, 0.1).least_gap, 0.01);
}

/// Half spheres as charts: domes that are flattened with some stretch, and gaps between them that
/// only deformation can fill.
struct Domes {
  Surface surface;
  std::vector<Chart> charts;
  std::vector<UvsX2> flat;
};

Domes MakeDomes() {
  Domes domes;
  domes.surface = MakeSurface(MakeIcosphere(4));
  for (int octant = 0; octant < 8; ++octant) {
    std::vector<int> faces;
    for (int f = 0; f < static_cast<int>(domes.surface.faces.rows()); ++f) {
      const Eigen::RowVector3d c = domes.surface.centers.row(f);
      if ((c.x() > 0) == ((octant & 1) > 0) && (c.y() > 0) == ((octant & 2) > 0) &&
          (c.z() > 0) == ((octant & 4) > 0))
        faces.push_back(f);
    }
    domes.charts.push_back(MakeChart(domes.surface, faces));
    domes.flat.push_back(*Flattened(domes.surface, domes.charts.back(), 100));
  }
  return domes;
}

TEST(PackElastically, SheetsBulgeIntoTheGapsAndKeepTheGutter) {
  const Domes domes = MakeDomes();
  std::vector<Shape> shapes;
  std::vector<const Chart*> charts;
  for (std::size_t i = 0; i < domes.charts.size(); ++i) {
    shapes.push_back({domes.flat[i], domes.charts[i].corners});
    charts.push_back(&domes.charts[i]);
  }
  const Packing packing = Pack(shapes, {512, 4});
  ElasticPackingOptions options;
  options.gap = 4.0 / 512;
  const Layout layout =
      PackElastically(domes.surface, charts, {packing.uvs, packing.scale}, options);
  double area = 0;
  std::vector<UvsX2> rims;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    EXPECT_TRUE(Upright(domes.surface, *charts[c], layout.uvs[c], 0));
    EXPECT_TRUE(RimIsSimple(*charts[c], layout.uvs[c]));
    rims.emplace_back(std::ssize(charts[c]->rim), 2);
    for (std::size_t i = 0; i < charts[c]->rim.size(); ++i)
      rims.back().row(i) = layout.uvs[c].row(charts[c]->rim[i]);
    area += OutlineArea(rims.back());
  }
  EXPECT_GE(FindContacts(rims, options.gap, 0.05).least_gap, options.gap);
  EXPECT_FALSE(AnyCross(rims));
  EXPECT_GT(area, packing.utilisation + 0.05);
}

}  // namespace keypose::texture::elastic_packing_test
