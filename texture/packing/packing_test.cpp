#include "texture/packing/packing.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/values/errors.h"
#include "texture/packing/contact.h"
#include "texture/packing/testing/outlines.h"

namespace keypose::texture::packing_test {

Shape SquareShape() {
  Shape shape;
  shape.points = Rectangle(0, 0, 1, 1);
  shape.corners.resize(2, 3);
  shape.corners << 0, 1, 2, 0, 2, 3;
  return shape;
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

}  // namespace keypose::texture::packing_test
