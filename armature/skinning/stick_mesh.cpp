#include "armature/skinning/stick_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Vector3d;

namespace {

// Radii, of the figure's diagonal, and of a bone's length where that is less.
constexpr double kBall = 0.009, kStick = 0.0065, kBallOfBone = 0.45, kStickOfBone = 0.3;
constexpr double kThinEnd = 0.5;  // of a stick's radius, at its tail

class Builder {
 public:
  void Add(const PointsX3& points, const FacesX3& faces, int bone,
           const Eigen::Matrix<std::uint8_t, 1, 3>& color) {
    const int first = SizeOf(points_);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
      points_.push_back(points.row(v));
      colors_.push_back(color);
      figure_.weights.bones.push_back({static_cast<std::uint16_t>(bone), 0, 0, 0});
      figure_.weights.weights.push_back({1, 0, 0, 0});
    }
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      faces_.push_back(faces.row(f) + Eigen::RowVector3i::Constant(first));
  }
  StickFigure Finish() {
    Mesh& mesh = figure_.mesh;
    mesh.points.resize(SizeOf(points_), 3);
    mesh.colors.resize(SizeOf(points_), 3);
    mesh.faces.resize(SizeOf(faces_), 3);
    for (int v = 0; v < SizeOf(points_); ++v) {
      mesh.points.row(v) = points_[v];
      mesh.colors.row(v) = colors_[v];
    }
    for (int f = 0; f < SizeOf(faces_); ++f) mesh.faces.row(f) = faces_[f];
    return std::move(figure_);
  }

 private:
  std::vector<Vector3d> points_;
  std::vector<Eigen::Matrix<std::uint8_t, 1, 3>> colors_;
  std::vector<Eigen::RowVector3i> faces_;
  StickFigure figure_;
};

/// A six-sided stick, thickest near its head, so that one sees which way a bone leads.
PointsX3 Stick(const SkinBone& bone, double radius, FacesX3* faces) {
  constexpr int kSides = 6;
  const Vector3d along = bone.tail - bone.head;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along);
  PointsX3 points(2 * kSides + 2, 3);
  faces->resize(4 * kSides, 3);
  const int head = 2 * kSides, tail = head + 1;
  points.row(head) = bone.head;
  points.row(tail) = bone.tail;
  for (int s = 0; s < kSides; ++s) {
    const double angle = 2 * EIGEN_PI * s / kSides;
    const Vector3d out = turn * Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0);
    points.row(s) = bone.head + 0.2 * along + out;
    points.row(kSides + s) = bone.head + 0.95 * along + kThinEnd * out;
    const int next = (s + 1) % kSides;
    faces->row(4 * s) << next, s, head;
    faces->row(4 * s + 1) << s, next, kSides + next;
    faces->row(4 * s + 2) << s, kSides + next, kSides + s;
    faces->row(4 * s + 3) << kSides + s, kSides + next, tail;
  }
  return points;
}

double DiagonalOf(const std::vector<SkinBone>& bones) {
  PointsX3 ends(2 * SizeOf(bones), 3);
  for (int b = 0; b < SizeOf(bones); ++b) {
    ends.row(2 * b) = bones[b].head;
    ends.row(2 * b + 1) = bones[b].tail;
  }
  return BoundingDiagonal(ends);
}

}  // namespace

StickFigure MakeStickFigure(const std::vector<SkinBone>& bones) {
  const double diagonal = DiagonalOf(bones);
  if (!(diagonal > 0)) throw InputError("armature: no bone of the skeleton has a length");
  const Mesh ball = MakeIcosphere(1);
  Builder builder;
  for (int b = 0; b < SizeOf(bones); ++b) {
    const double length = (bones[b].tail - bones[b].head).norm();
    if (!(length > 0)) continue;
    FacesX3 faces;
    const PointsX3 stick =
        Stick(bones[b], std::min(kStick * diagonal, kStickOfBone * length), &faces);
    builder.Add(stick, faces, b, {226, 204, 160});
    const double radius = std::min(kBall * diagonal, kBallOfBone * length);
    PointsX3 points = radius * ball.points;
    points.rowwise() += bones[b].tail.transpose();
    builder.Add(points, ball.faces, b, {150, 70, 52});
  }
  return builder.Finish();
}

}  // namespace keypose::armature
