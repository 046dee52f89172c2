#include "texture/charts/parametrise.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "core/numbers/cholesky.h"
#include "core/values/size_of.h"
#include "texture/charts/elastic_sheet.h"

namespace keypose::texture {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSettled = 1e-5;
constexpr double kLeastArea = 0.02;  // of the area in space: smaller triangles count as flipped

UvsX2 Projected(const Surface& s, const Chart& chart) {
  Vector3d normal = Vector3d::Zero();
  for (const int f : chart.faces) normal += s.areas[f] * s.normals.row(f).transpose();
  const Vector3d x = normal.unitOrthogonal(), y = normal.normalized().cross(x);
  UvsX2 uvs(std::ssize(chart.vertices), 2);
  for (int v = 0; v < std::ssize(chart.vertices); ++v) {
    const Vector3d p = s.points.row(chart.vertices[v]);
    uvs.row(v) << x.dot(p), y.dot(p);
  }
  return uvs;
}

// The boundary on a circle by arc length, every other vertex at the weighted mean of its
// neighbours: no triangle can flip.
UvsX2 Tutte(const Surface& s, const Chart& chart, const RestShape& rest) {
  const int count = SizeOf(chart.vertices);
  UvsX2 uvs = UvsX2::Zero(count, 2);
  std::vector<int> column(count, 0);
  double length = 0;
  const auto rim = [&](std::size_t i) -> Vector3d {
    return s.points.row(chart.vertices[chart.rim[i % chart.rim.size()]]);
  };
  for (std::size_t i = 0; i < chart.rim.size(); ++i) length += (rim(i + 1) - rim(i)).norm();
  const double radius = std::sqrt(rest.area / EIGEN_PI);
  double at = 0;
  for (std::size_t i = 0; i < chart.rim.size(); ++i) {
    column[chart.rim[i]] = -1;
    uvs.row(chart.rim[i]) << radius * std::cos(2 * EIGEN_PI * at / length),
        radius * std::sin(2 * EIGEN_PI * at / length);
    at += (rim(i + 1) - rim(i)).norm();
  }
  int inner = 0;
  for (int& c : column)
    if (c >= 0) c = inner++;
  if (inner == 0) return uvs;
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(inner, 2);
  for (int i = 0; i < std::ssize(chart.faces); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int p = chart.corners(i, k), q = chart.corners(i, (k + 1) % 3);
      if (column[p] >= 0 && column[q] < 0) b.row(column[p]) += rest.cotangents[i][k] * uvs.row(q);
      if (column[q] >= 0 && column[p] < 0) b.row(column[q]) += rest.cotangents[i][k] * uvs.row(p);
    }
  }
  const Eigen::SparseMatrix<double> matrix = ChartLaplacian(chart, rest, column, inner);
  SparseCholesky solver;
  solver.Analyze(matrix);
  solver.Factor(matrix);
  const Eigen::MatrixXd x = solver.Solve(b);
  for (int v = 0; v < count; ++v)
    if (column[v] >= 0) uvs.row(v) = x.row(column[v]);
  return uvs;
}

double Turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

bool Cross(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  if (std::max(a.x(), b.x()) < std::min(c.x(), d.x()) ||
      std::max(c.x(), d.x()) < std::min(a.x(), b.x()))
    return false;
  if (std::max(a.y(), b.y()) < std::min(c.y(), d.y()) ||
      std::max(c.y(), d.y()) < std::min(a.y(), b.y()))
    return false;
  return (Turn(a, b, c) > 0) != (Turn(a, b, d) > 0) && (Turn(c, d, a) > 0) != (Turn(c, d, b) > 0);
}

}  // namespace

// A map of a disk without flips and with a simple boundary polygon is injective; the exact test
// follows after packing.
bool RimIsSimple(const Chart& chart, const UvsX2& uvs) {
  const std::size_t n = chart.rim.size();
  std::vector<Vector2d> p;
  for (const int v : chart.rim) p.emplace_back(uvs.row(v).transpose());
  // edges by their left end: a sweep leaves few pairs
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < n; ++i) order.emplace_back(std::min(p[i].x(), p[(i + 1) % n].x()), i);
  std::sort(order.begin(), order.end());
  for (std::size_t m = 0; m < n; ++m) {
    const std::size_t i = order[m].second;
    const double right = std::max(p[i].x(), p[(i + 1) % n].x());
    for (std::size_t l = m + 1; l < n && order[l].first <= right; ++l) {
      const std::size_t j = order[l].second;
      if ((i + 1) % n == j || (j + 1) % n == i) continue;
      if (Cross(p[i], p[(i + 1) % n], p[j], p[(j + 1) % n])) return false;
    }
  }
  return true;
}

std::optional<UvsX2> Flattened(const Surface& surface, const Chart& chart, int iterations) {
  const Sheet sheet(surface, chart, 0);
  UvsX2 uvs = Projected(surface, chart);
  if (!Upright(surface, chart, uvs, 0.1)) uvs = Tutte(surface, chart, sheet.rest());
  for (int round = 0; round < iterations; ++round)
    if (sheet.Settle(1, {}, uvs) <= kSettled) break;
  double flat_area = 0;
  for (int i = 0; i < std::ssize(chart.faces); ++i) flat_area += SignedArea(uvs, chart, i);
  if (!(flat_area > 0)) return std::nullopt;
  uvs *= std::sqrt(sheet.rest().area / flat_area);
  if (!uvs.allFinite() || !Upright(surface, chart, uvs, kLeastArea) || !RimIsSimple(chart, uvs))
    return std::nullopt;
  return uvs;
}

Vector2d Stretches(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector2d& p,
                   const Vector2d& q, const Vector2d& r) {
  const RestTriangle flat = RestOf(a, b, c);
  if (!(flat.x1 * flat.y2 > 0)) return Vector2d::Constant(std::numeric_limits<double>::infinity());
  Matrix2d from, to;
  from << flat.x1, flat.x2, 0, flat.y2;
  to << q - p, r - p;
  const Matrix2d j = to * from.inverse();
  // Singular values of a 2 x 2 matrix in closed form.
  const double e = (j(0, 0) + j(1, 1)) / 2, f = (j(0, 0) - j(1, 1)) / 2,
               g = (j(1, 0) + j(0, 1)) / 2, h = (j(1, 0) - j(0, 1)) / 2;
  const double u = std::hypot(e, h), v = std::hypot(f, g);
  return {u + v, std::abs(u - v)};
}

double ConformalRatio(const Surface& surface, const Chart& chart, const UvsX2& uvs, int i) {
  const int f = chart.faces[i];
  const auto point = [&](int k) -> Vector3d { return surface.points.row(surface.faces(f, k)); };
  const auto uv = [&](int k) -> Vector2d { return uvs.row(chart.corners(i, k)); };
  const Vector2d s = Stretches(point(0), point(1), point(2), uv(0), uv(1), uv(2));
  return s[0] / s[1];
}

Distortion MeasureDistortion(const Surface& surface, const Chart& chart, const UvsX2& uvs) {
  std::vector<std::pair<double, double>> values;  // distortion, area
  Distortion out;
  double sum = 0, area = 0;
  for (int i = 0; i < std::ssize(chart.faces); ++i) {
    const int f = chart.faces[i];
    const auto point = [&](int k) -> Vector3d { return surface.points.row(surface.faces(f, k)); };
    const auto uv = [&](int k) -> Vector2d { return uvs.row(chart.corners(i, k)); };
    const Vector2d s = Stretches(point(0), point(1), point(2), uv(0), uv(1), uv(2));
    const double value = std::max(s[0], 1 / s[1]);
    values.emplace_back(value, surface.areas[f]);
    sum += surface.areas[f] * value;
    area += surface.areas[f];
  }
  out.mean = area > 0 ? sum / area : std::numeric_limits<double>::infinity();
  std::sort(values.begin(), values.end());
  out.max = values.back().first;
  double below = 0;
  for (const auto& [value, weight] : values) {
    below += weight;
    out.p99 = value;
    if (below >= 0.99 * area) break;
  }
  return out;
}

}  // namespace keypose::texture
