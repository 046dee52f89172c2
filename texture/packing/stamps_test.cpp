#include "texture/packing/stamps.h"

#include <gtest/gtest.h>

namespace keypose::texture::stamps_test {

UvsX2 Rectangle(double width, double height) {
  UvsX2 outline(4, 2);
  outline << 0, 0, width, 0, width, height, 0, height;
  return outline;
}

TEST(Turned, AQuarterTurnMapsXToY) {
  UvsX2 points(1, 2);
  points << 2, 0;
  const UvsX2 turned = Turned(points, kPi / 2);
  EXPECT_NEAR(turned(0, 0), 0, 1e-12);
  EXPECT_NEAR(turned(0, 1), 2, 1e-12);
}

TEST(Widened, EdgesOfARectangleMoveOutwardsBySoMuch) {
  const UvsX2 wide = Widened(Rectangle(10, 6), 0.5);
  EXPECT_NEAR(wide(0, 0), -0.5, 1e-9);
  EXPECT_NEAR(wide(0, 1), -0.5, 1e-9);
  EXPECT_NEAR(wide(2, 0), 10.5, 1e-9);
  EXPECT_NEAR(wide(2, 1), 6.5, 1e-9);
}

TEST(DrawStamp, CoversTheCellsWhoseCentresAreInside) {
  UvsX2 moved = Rectangle(12, 8);
  moved.rowwise() += Eigen::RowVector2d(3, -5);
  const Stamp stamp = DrawStamp(moved);
  EXPECT_EQ(stamp.width, 12);
  EXPECT_EQ(stamp.height, 8);
  EXPECT_EQ(stamp.cells, 96);
  EXPECT_EQ(stamp.low, Eigen::Vector2d(3, -5));

  UvsX2 triangle(3, 2);
  triangle << 0, 0, 20, 0, 0, 20;
  EXPECT_NEAR(DrawStamp(triangle).cells, 200, 15);
}

TEST(DrawStamp, AnOutlineOfFewCellsIsItsBox) {
  UvsX2 triangle(3, 2);
  triangle << 0, 0, 4, 0, 0, 4;
  EXPECT_EQ(DrawStamp(triangle).cells, 16);
}

TEST(OccupiedCells, AStampFitsBesideWhatIsThere) {
  const Stamp stamp = DrawStamp(Rectangle(10, 8));
  OccupiedCells cells(32);
  EXPECT_EQ(cells.FirstFree(stamp, 0, 0), 0);
  cells.Add(stamp, 0, 0);
  EXPECT_EQ(cells.FirstFree(stamp, 0, 4), 10);
  EXPECT_EQ(cells.FirstFree(stamp, 0, 8), 0);
  cells.Add(stamp, 10, 0);
  EXPECT_EQ(cells.FirstFree(stamp, 0, 0), 20);
  cells.Add(stamp, 20, 0);
  EXPECT_EQ(cells.FirstFree(stamp, 0, 0), -1);
}

}  // namespace keypose::texture::stamps_test
