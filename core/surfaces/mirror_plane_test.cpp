#include "core/surfaces/mirror_plane.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::mirror_plane_test {

using Eigen::Vector3d;

/// A body with a nose in the plane x = 0 and an arm to each side, one of which may be lifted.
Mesh Figure(bool lifted) {
  Mesh mesh = MakeIcosphere(4);
  const auto bump = [](const Vector3d& p, const Vector3d& at, double width) {
    return std::exp(-(p - at.normalized()).squaredNorm() / (width * width));
  };
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Vector3d p = mesh.points.row(v);
    double length = 1 + 0.5 * bump(p, {0, -1, 0.4}, 0.3);
    length += 0.9 * bump(p, {1, 0, 0.1}, 0.25);
    length += 0.9 * bump(p, lifted ? Vector3d(-1, 0, 0.9) : Vector3d(-1, 0, 0.1), 0.25);
    // Bent forward, so that front and back differ.
    mesh.points.row(v) = (length * p).cwiseProduct(Vector3d(0.8, 0.6, 1.3));
    mesh.points(v, 1) -= 0.4 * p[2] * std::abs(p[2]) + 0.3 * p[2];
  }
  return mesh;
}

TEST(MirrorPlane, IsFoundOfATurnedAndMovedFigure) {
  for (const bool lifted : {false, true}) {
    Mesh mesh = Figure(lifted);
    const double turn = 37 * std::numbers::pi / 180;
    const Eigen::Matrix3d about = Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
    mesh.points = mesh.points * about.transpose();
    mesh.points.rowwise() += Eigen::RowVector3d(0.4, -0.2, 0);
    const MirrorPlane plane = FindMirrorPlane(mesh.points, mesh.faces);
    const Vector3d normal = about.col(0);
    const double angle =
        std::acos(std::min(1.0, std::abs(plane.normal.dot(normal)))) * 180 / std::numbers::pi;
    EXPECT_TRUE(plane.found()) << plane.misfit;
    EXPECT_LT(angle, lifted ? 3 : 0.6);
    EXPECT_LT(std::abs(plane.Distance({0.4, -0.2, 0.5})), lifted ? 0.06 : 0.015);
    const Vector3d hand = about * Vector3d(1.5, 0, 0.1) + Vector3d(0.4, -0.2, 0);
    const Vector3d other = about * Vector3d(-1.5, 0, 0.1) + Vector3d(0.4, -0.2, 0);
    EXPECT_LT((plane.Mirrored(hand) - other).norm(), lifted ? 0.15 : 0.04);
  }
}

TEST(MirrorPlane, IsNotFoundOfAFigureThatHasNone) {
  Mesh mesh = MakeIcosphere(4);
  // A screw: each height is turned.
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Vector3d p = mesh.points.row(v);
    const double turn = 2.5 * p[2];
    mesh.points.row(v) =
        Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * Vector3d(1.8 * p[0], 0.4 * p[1], 1.5 * p[2]);
  }
  EXPECT_FALSE(FindMirrorPlane(mesh.points, mesh.faces).found());
  EXPECT_THROW(FindMirrorPlane(mesh.points, FacesX3(0, 3)), InputError);
}

}  // namespace keypose::mirror_plane_test
