// Picks that are transferred to a rebuilt mesh.
#include "core/surfaces/carry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::carry_test {

/// A shape without symmetry: a ball whose radius and colour vary with direction. `levels` and
/// `turn` change the vertices but not the shape.
Mesh Lump(int levels, double turn_rad, bool arm_down = false) {
  Mesh mesh = MakeIcosphere(levels);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(turn_rad, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  mesh.points = (turn * mesh.points.transpose()).transpose().eval();
  mesh.colors.resize(mesh.points.rows(), 3);
  const Eigen::Vector3d arm =
      arm_down ? Eigen::Vector3d(1, 0, -0.9).normalized() : Eigen::Vector3d(1, 0, 0.9).normalized();
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d d = mesh.points.row(v).transpose();
    const auto bump = [&](const Eigen::Vector3d& at, double width) {
      return std::exp(-(d - at.normalized()).squaredNorm() / width);
    };
    const double r = 1 + 0.9 * bump(arm, 0.08) + 0.5 * bump({-1, 0.3, -0.2}, 0.1) +
                     0.35 * bump({0, -1, 0.5}, 0.05) + 0.2 * d.z();
    mesh.points.row(v) = r * d.transpose();
    mesh.colors.row(v) << static_cast<std::uint8_t>(120 + 60 * d.x()),
        static_cast<std::uint8_t>(120 + 60 * d.y()), 90;
  }
  return mesh;
}

Similarity3 Moved() {
  Similarity3 move;
  move.scale = 1.3;
  move.rotation =
      Eigen::AngleAxisd(2.0, Eigen::Vector3d(0.3, -1, 0.5).normalized()).toRotationMatrix();
  move.translation = {4, -2, 1};
  return move;
}

/// A place on every `stride`-th face.
std::vector<SurfacePlace> Places(const Mesh& mesh, int stride) {
  const SurfacePlaces places(mesh);
  std::vector<SurfacePlace> list;
  for (int f = 0; f < mesh.face_count(); f += stride) list.push_back(places.At(f, {0.2, 0.3, 0.5}));
  return list;
}

Eigen::Vector3d PointOf(const CarriedPlace& carried, const Mesh& mesh) {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    point += carried.barycentric[k] * mesh.points.row(mesh.faces(carried.face, k)).transpose();
  return point;
}

/// Largest distance of transferred places from their true positions, over the diagonal.
double WorstError(const Mesh& before, const Mesh& now, const Similarity3& now_from_before) {
  const Carrier carrier(BindTo(before), now);
  double worst = 0;
  for (const SurfacePlace& place : Places(before, 97)) {
    const CarriedPlace carried = carrier.Carry(place);
    EXPECT_EQ(carried.grade, CarriedPlace::Grade::kSure) << carried.why;
    if (carried.face < 0) return 1;
    worst = std::max(worst, (PointOf(carried, now) - now_from_before * place.position).norm() /
                                BoundingDiagonal(now.points));
  }
  return worst;
}

TEST(GeometryHash, IsOfPositionsAndFacesAlone) {
  const Mesh mesh = Lump(3, 0);
  Mesh same = mesh;
  same.colors.setZero();
  same.points.array() *= 1 + 1e-15;  // the bits that an OBJ loses
  EXPECT_EQ(GeometryHash(same), GeometryHash(mesh));
  same.points(7, 1) += 1e-3;
  EXPECT_NE(GeometryHash(same), GeometryHash(mesh));
  EXPECT_EQ(NumberingHash(same), NumberingHash(mesh));
  std::swap(same.faces(0, 0), same.faces(0, 1));
  EXPECT_NE(NumberingHash(same), NumberingHash(mesh));
}

TEST(Carrier, FollowsToOtherVerticesInTheSameFrame) {
  const Mesh before = Lump(4, 0), now = Lump(4, 0.5);
  EXPECT_TRUE(Carrier(BindTo(before), now).change().same_frame);
  EXPECT_LT(WorstError(before, now, {}),
            0.002);  // half the distance of a face from the true surface
}

TEST(Carrier, FollowsThroughATurnAndAnotherScale) {
  const Mesh before = Lump(4, 0);
  Mesh now = Lump(4, 0.5);
  now.points = Transformed(Moved(), now.points);
  const Carrier carrier(BindTo(before), now);
  EXPECT_FALSE(carrier.change().same_frame);
  EXPECT_NEAR(carrier.change().now_from_before.scale, 1.3, 0.005);
  EXPECT_LT(WorstError(before, now, Moved()), 0.005);
}

TEST(Carrier, NeedsNoColoursAndNotTheSameBrightness) {
  const Mesh before = Lump(4, 0);
  Mesh now = Lump(4, 0.5);
  now.points = Transformed(Moved(), now.points);
  now.colors = (now.colors.cast<double>().array() * 1.2).min(255).cast<std::uint8_t>();
  EXPECT_LT(WorstError(before, now, Moved()), 0.005);
  now.colors.resize(0, 3);
  EXPECT_LT(WorstError(before, now, Moved()), 0.005);
}

TEST(Carrier, AnotherShapeIsRefusedForAllPicks) {
  const Mesh before = Lump(4, 0), box = MakeBox(1, 2, 5);
  const Carrier carrier(BindTo(before), box);
  for (const SurfacePlace& place : Places(before, 500)) {
    const CarriedPlace carried = carrier.Carry(place);
    EXPECT_EQ(carried.grade, CarriedPlace::Grade::kLost);
    EXPECT_FALSE(carried.why.empty());
  }
}

TEST(Carrier, OnlyThePicksOnTheArmThatMovedAreLost) {
  const Mesh before = Lump(4, 0), now = Lump(4, 0.5, true);
  const Carrier carrier(BindTo(before), now);
  int kept = 0, lost = 0;
  for (const SurfacePlace& place : Places(before, 29)) {
    const bool on_arm = place.position.dot(Eigen::Vector3d(1, 0, 0.9).normalized()) > 1.5;
    const bool on_body = place.position.x() < 0;
    const bool is_lost = carrier.Carry(place).grade == CarriedPlace::Grade::kLost;
    EXPECT_TRUE(is_lost || !on_arm) << place.position.transpose();
    EXPECT_FALSE(is_lost && on_body) << carrier.Carry(place).why;
    kept += on_body, lost += on_arm;
  }
  EXPECT_GT(kept, 20);
  EXPECT_GT(lost, 3);
}

TEST(Carrier, WhatLooksTheSameFromSeveralSidesIsNotGuessed) {
  const Mesh before = MakeCylinder(1, 5, 24, 30);
  Mesh now = before;
  now.points = Transformed(Moved(), now.points);
  const Carrier carrier(BindTo(before), now);
  EXPECT_TRUE(carrier.change().ambiguous);
  EXPECT_EQ(carrier.Carry(Places(before, 100)[0]).grade, CarriedPlace::Grade::kLost);
}

TEST(Carrier, SameBitsForAnyThreadCount) {
  const Mesh before = Lump(3, 0);
  Mesh now = Lump(3, 0.5);
  now.points = Transformed(Moved(), now.points);
  SetThreadCount(1);
  const Eigen::Matrix3d one = Carrier(BindTo(before), now).change().now_from_before.rotation;
  SetThreadCount(4);
  const Eigen::Matrix3d four = Carrier(BindTo(before), now).change().now_from_before.rotation;
  SetThreadCount(0);
  EXPECT_EQ(one, four);
}

}  // namespace keypose::carry_test
