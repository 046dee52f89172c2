#include "texture/packing/packing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "texture/charts/parametrise.h"
#include "texture/packing/contact.h"
#include "texture/packing/elastic_packing.h"
#include "texture/packing/nesting.h"

namespace keypose::texture::packing_test {

UvsX2 Rectangle(double x, double y, double width, double height) {
  UvsX2 p(4, 2);
  p << x, y, x + width, y, x + width, y + height, x, y + height;
  return p;
}

/// A star of triangles around the origin: `tips` bumps of relative height `depth`.
Shape Star(int tips, double depth) {
  const int n = 8 * tips;
  Shape shape;
  shape.points = UvsX2::Zero(n + 1, 2);
  shape.corners.resize(n, 3);
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * EIGEN_PI * i / n, r = 1 + depth * std::cos(tips * angle);
    shape.points.row(i) << r * std::cos(angle), r * std::sin(angle);
    shape.corners.row(i) << n, i, (i + 1) % n;
  }
  return shape;
}

Shape SquareShape() {
  Shape shape;
  shape.points = Rectangle(0, 0, 1, 1);
  shape.corners.resize(2, 3);
  shape.corners << 0, 1, 2, 0, 2, 3;
  return shape;
}

double OutlineArea(const UvsX2& p) {
  double sum = 0;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Eigen::Index j = (i + 1) % p.rows();
    sum += p(i, 0) * p(j, 1) - p(j, 0) * p(i, 1);
  }
  return sum / 2;
}

TEST(Pack, ManySquaresFitWithoutMirroring) {
  const Packing packing = Pack(std::vector<Shape>(16, SquareShape()), {512, 2});
  EXPECT_GT(packing.utilisation, 0.85);
  for (const UvsX2& uvs : packing.uvs) {
    const Eigen::RowVector2d a = uvs.row(1) - uvs.row(0), b = uvs.row(2) - uvs.row(0);
    EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0);
  }
}

TEST(Pack, ShapesKeepTheirShapeAndTheGutter) {
  std::vector<Shape> shapes;
  for (int i = 0; i < 9; ++i) shapes.push_back(Star(3 + i % 4, 0.1 + 0.05 * i));
  const Packing packing = Pack(shapes, {256, 5});
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (int v = 0; v < 8; ++v) {
      const double before = (shapes[i].points.row(v) - shapes[i].points.row(v + 5)).norm();
      EXPECT_NEAR((packing.uvs[i].row(v) - packing.uvs[i].row(v + 5)).norm(),
                  packing.scale * before, 1e-12);
    }
  }
  // The centres of the stars are inside; all other vertices are on the boundaries.
  std::vector<UvsX2> rims;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    rims.push_back(packing.uvs[i].topRows(packing.uvs[i].rows() - 1));
  EXPECT_GE(FindContacts(rims, 5.0 / 256, 0.1).least_gap, 5.0 / 256 - 1e-12);
  EXPECT_FALSE(AnyCross(rims));
  EXPECT_GT(packing.utilisation, 0.45);
}

TEST(Pack, FarTooManyShapesForTheGutterIsAQualityError) {
  Shape shape;
  shape.points.resize(3, 2);
  shape.points << 0, 0, 1, 0, 0, 1;
  shape.corners.resize(1, 3);
  shape.corners << 0, 1, 2;
  EXPECT_THROW(Pack(std::vector<Shape>(400, shape), {64, 8}), QualityError);
}

TEST(Nested, ThreeRectanglesThatTileTheSquareFillIt) {
  const std::vector<UvsX2> tiles = {Rectangle(0, 0, 0.5, 1), Rectangle(3, 3, 0.5, 0.5),
                                    Rectangle(0, 0, 0.5, 0.5)};
  const Nesting nesting = Nested(tiles, {});
  EXPECT_GT(nesting.scale, 0.97);
  EXPECT_LT(nesting.scale, 1.01);  // half a cell of overlap each
}

TEST(Nested, SearchBeatsItsBottomLeftStart) {
  std::vector<UvsX2> outlines;
  for (int i = 0; i < 14; ++i) {
    const Shape star = Star(2 + i % 5, 0.15 + 0.04 * (i % 7));
    outlines.push_back((0.4 + 0.1 * (i % 6)) * star.points.topRows(star.points.rows() - 1));
  }
  NestingOptions none;
  none.effort = 0;
  double area = 0;
  for (const UvsX2& p : outlines) area += OutlineArea(p);
  const double start = area * std::pow(Nested(outlines, none).scale, 2),
               searched = area * std::pow(Nested(outlines, {}).scale, 2);
  EXPECT_GT(searched, start + 0.02);
  EXPECT_GT(searched, 0.72);
}

TEST(Nested, SameForAnyThreadCount) {
  std::vector<UvsX2> outlines;
  for (int i = 0; i < 8; ++i) outlines.push_back(Star(3, 0.05 * i).points.topRows(24));
  SetThreadCount(1);
  const Nesting one = Nested(outlines, {});
  SetThreadCount(2);
  const Nesting two = Nested(outlines, {});
  SetThreadCount(0);
  EXPECT_EQ(one.scale, two.scale);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(one.places[i].offset, two.places[i].offset);
}

TEST(FindContacts, NearSquaresArePushedApartByHalfOfWhatIsMissingEach) {
  const std::vector<UvsX2> rims = {Rectangle(0.1, 0.4, 0.2, 0.2), Rectangle(0.31, 0.4, 0.2, 0.2)};
  const Contacts contacts = FindContacts(rims, 0.02, 0.05);
  EXPECT_NEAR(contacts.least_gap, 0.01, 1e-12);
  EXPECT_NEAR(contacts.push[0](1, 0), -0.005, 1e-12);
  EXPECT_NEAR(contacts.push[1](0, 0), 0.005, 1e-12);
  EXPECT_EQ(contacts.push[0](0, 0), 0);  // the far side has no contact
  EXPECT_NEAR(contacts.push[0](1, 1), 0, 1e-12);
}

TEST(FindContacts, DepthOfAnOverlapIsNegative) {
  const std::vector<UvsX2> rims = {Rectangle(0.1, 0.4, 0.2, 0.2), Rectangle(0.29, 0.45, 0.2, 0.1)};
  EXPECT_NEAR(FindContacts(rims, 0.02, 0.05).least_gap, -0.01, 1e-12);
}

TEST(FindContacts, BorderCountsForHalfOfTheGap) {
  const Contacts contacts = FindContacts({Rectangle(0.004, 0.4, 0.2, 0.2)}, 0.02, 0.05);
  EXPECT_NEAR(contacts.least_gap, 0.008, 1e-12);
  EXPECT_NEAR(contacts.push[0](0, 0), 0.006, 1e-12);
}

TEST(FindContacts, NarrowBayIsPushedOpenAndANeckIsNot) {
  UvsX2 bay(8, 2);  // a square with a slot of 0.004 from above
  bay << 0.3, 0.3, 0.5, 0.3, 0.5, 0.5, 0.402, 0.5, 0.402, 0.4, 0.398, 0.4, 0.398, 0.5, 0.3, 0.5;
  const Contacts contacts = FindContacts({bay}, 0.02, 0.05);
  EXPECT_GT(contacts.push[0](3, 0), 0);
  EXPECT_LT(contacts.push[0](6, 0), 0);
  UvsX2 neck = Rectangle(0.3, 0.3, 0.004, 0.2);
  EXPECT_TRUE(FindContacts({neck}, 0.02, 0.05).push[0].isZero(0));
}

TEST(AnyCross, BarsThatCrossWithAllCornersOutsideOfEachOther) {
  const std::vector<UvsX2> cross = {Rectangle(0.1, 0.45, 0.8, 0.1), Rectangle(0.45, 0.1, 0.1, 0.8)};
  EXPECT_TRUE(AnyCross(cross));
  EXPECT_FALSE(AnyCross({cross[0], Rectangle(0.45, 0.6, 0.1, 0.3)}));
}

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

}  // namespace keypose::texture::packing_test
