// Bars and hollow balls that the tests of the solid mode share.
#pragma once

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::interpolation {

constexpr double kPi = std::numbers::pi;

inline Eigen::Matrix3d Turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}
inline double Gap(const PointsX3& a, const PointsX3& b) {
  return (a - b).rowwise().norm().maxCoeff() / BoundingDiagonal(b);
}
inline bool SameBits(const PointsX3& a, const PointsX3& b) {
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

/// A bar of length 2 along z, round or square across.
struct Bar {
  static constexpr int kSegments = 24, kRings = 40;
  explicit Bar(double radius, bool square = false)
      : mesh(MakeCylinder(radius, 2, kSegments, kRings)) {
    if (!square) return;
    for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) {
      const double reach = std::max(std::abs(mesh.points(i, 0)), std::abs(mesh.points(i, 1)));
      if (reach > 0) mesh.points.row(i).head<2>() *= radius / reach;
    }
  }

  PointsX3 Twisted(double angle) const {
    PointsX3 p = mesh.points;
    for (Eigen::Index i = 0; i < p.rows(); ++i)
      p.row(i) *= Turn(angle * p(i, 2) / 2, Eigen::Vector3d::UnitZ()).transpose();
    return p;
  }
  PointsX3 Bent(double angle) const {
    PointsX3 p = mesh.points;
    const double radius = 2 / angle;
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const double a = mesh.points(i, 2) / radius, r = radius - mesh.points(i, 0);
      p.row(i) << radius - r * std::cos(a), mesh.points(i, 1), r * std::sin(a);
    }
    return p;
  }
  /// Area of each ring of vertices, except the two at either end, whose shape the caps determine.
  std::vector<double> CrossSections(const PointsX3& p) const {
    std::vector<double> areas;
    for (int r = 2; r <= kRings - 2; ++r) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int s = 0; s < kSegments; ++s) {
        const Eigen::Vector3d a = p.row(r * kSegments + s) - p.row(r * kSegments),
                              b = p.row(r * kSegments + (s + 1) % kSegments) - p.row(r * kSegments);
        sum += a.cross(b);
      }
      areas.push_back(0.5 * sum.norm());
    }
    return areas;
  }
  double SmallestCrossSection(const PointsX3& p) const {
    const std::vector<double> now = CrossSections(p), rest = CrossSections(mesh.points);
    double least = 1e9;
    for (std::size_t r = 0; r < now.size(); ++r) least = std::min(least, now[r] / rest[r]);
    return least;
  }
  Mesh mesh;
};

inline void Join(Mesh& mesh, const Mesh& other) {
  const int v = mesh.vertex_count(), f = mesh.face_count();
  mesh.points.conservativeResize(v + other.vertex_count(), 3);
  mesh.points.bottomRows(other.vertex_count()) = other.points;
  mesh.faces.conservativeResize(f + other.face_count(), 3);
  mesh.faces.bottomRows(other.face_count()) = other.faces.array() + v;
}

/// A ball with a ball-shaped hollow.
inline Mesh HollowBall() {
  Mesh mesh = MakeIcosphere(2), hollow = MakeIcosphere(2);
  hollow.points *= 0.5;
  hollow.faces.col(1).swap(hollow.faces.col(2));
  Join(mesh, hollow);
  return mesh;
}

inline std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no InputError";
}

}  // namespace keypose::interpolation
