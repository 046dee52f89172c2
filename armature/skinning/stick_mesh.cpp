#include "armature/skinning/stick_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "core/errors.h"
#include "core/size_of.h"
#include "core/testing_shapes.h"

namespace keypose::armature {

using Eigen::Vector3d;

namespace {

constexpr double kBall = 0.16, kStick = 0.09, kThinnest = 0.35;  // of the middle bone's length

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
    for (int v = 0; v < SizeOf(points_); ++v)
      mesh.points.row(v) = points_[v], mesh.colors.row(v) = colors_[v];
    for (int f = 0; f < SizeOf(faces_); ++f) mesh.faces.row(f) = faces_[f];
    return std::move(figure_);
  }

 private:
  std::vector<Vector3d> points_;
  std::vector<Eigen::Matrix<std::uint8_t, 1, 3>> colors_;
  std::vector<Eigen::RowVector3i> faces_;
  StickFigure figure_;
};

/// A six-sided spindle, thickest near its head, so that one sees which way a bone leads.
PointsX3 Spindle(const SkinBone& bone, double radius, FacesX3* faces) {
  constexpr int kSides = 6;
  const Vector3d along = bone.tail - bone.head;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along);
  PointsX3 points(kSides + 2, 3);
  faces->resize(2 * kSides, 3);
  points.row(kSides) = bone.head;
  points.row(kSides + 1) = bone.tail;
  for (int s = 0; s < kSides; ++s) {
    const double angle = 2 * EIGEN_PI * s / kSides;
    points.row(s) = bone.head + 0.2 * along +
                    turn * Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0);
    faces->row(2 * s) << s, (s + 1) % kSides, kSides + 1;
    faces->row(2 * s + 1) << (s + 1) % kSides, s, kSides;
  }
  return points;
}

}  // namespace

StickFigure MakeStickFigure(const std::vector<SkinBone>& bones) {
  std::vector<double> lengths;
  for (const SkinBone& bone : bones)
    if ((bone.tail - bone.head).norm() > 0) lengths.push_back((bone.tail - bone.head).norm());
  if (lengths.empty()) throw InputError("armature: no bone of the skeleton has a length");
  std::nth_element(lengths.begin(), lengths.begin() + SizeOf(lengths) / 2, lengths.end());
  const double middle = lengths[lengths.size() / 2];
  const Mesh ball = MakeIcosphere(1);
  Builder builder;
  for (int b = 0; b < SizeOf(bones); ++b) {
    const double length = (bones[b].tail - bones[b].head).norm();
    if (!(length > 0)) continue;
    const double size = std::clamp(length, kThinnest * middle, middle);
    FacesX3 faces;
    const PointsX3 stick = Spindle(bones[b], kStick * size, &faces);
    builder.Add(stick, faces, b, {226, 204, 160});
    const double radius = kBall * size * 0.6;
    PointsX3 points = radius * ball.points;
    points.rowwise() += bones[b].tail.transpose();
    builder.Add(points, ball.faces, b, {150, 70, 52});
  }
  return builder.Finish();
}

}  // namespace keypose::armature
