// Points of a sphere.
#pragma once

#include <gmock/gmock.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::reconstruct {

inline const Eigen::RowVector3d kCenter(3, -2, 10);
constexpr double kRadius = 5;

// Nearly even points on a sphere (a golden-angle spiral); red above the middle, blue below.
inline PointCloud SphereCloud(int count) {
  PointCloud cloud;
  cloud.points.resize(count, 3);
  cloud.normals.resize(count, 3);
  cloud.colors.resize(count, 3);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, ring = std::sqrt(1 - z * z);
    const double turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    cloud.normals.row(i) << ring * std::cos(turn), ring * std::sin(turn), z;
    cloud.points.row(i) = kCenter + kRadius * cloud.normals.row(i);
    cloud.colors.row(i) << (z > 0 ? 220 : 10), 30, (z > 0 ? 10 : 220);
  }
  return cloud;
}

inline PointCloud Rows(const PointCloud& cloud, const std::vector<int>& rows) {
  return {cloud.points(rows, Eigen::all),
          cloud.normals(rows, Eigen::all),
          cloud.colors(rows, Eigen::all),
          {}};
}

inline PointCloud UpperCap(const PointCloud& cloud, double lowest_z) {
  std::vector<int> rows;
  for (int i = 0; i < cloud.points.rows(); ++i) {
    if (cloud.normals(i, 2) > lowest_z) rows.push_back(i);
  }
  return Rows(cloud, rows);
}

inline PointCloud Joined(const PointCloud& a, const PointCloud& b) {
  PointCloud out{PointsX3(a.points.rows() + b.points.rows(), 3),
                 PointsX3(a.points.rows() + b.points.rows(), 3),
                 ColorsX3(a.points.rows() + b.points.rows(), 3),
                 {}};
  out.points << a.points, b.points;
  out.normals << a.normals, b.normals;
  out.colors << a.colors, b.colors;
  return out;
}

}  // namespace keypose::reconstruct
