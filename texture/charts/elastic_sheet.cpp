#include "texture/charts/elastic_sheet.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The rotation nearest to the map of a face, weighted by its cotangents.
Vector2d BestRotation(const Vector2d* edges, const std::array<double, 3>& cot, const UvsX2& uvs,
                      const Eigen::RowVector3i& corner) {
  double c = 0, s = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector2d& e = edges[k];
    const double ux = uvs(corner[(k + 1) % 3], 0) - uvs(corner[k], 0),
                 uy = uvs(corner[(k + 1) % 3], 1) - uvs(corner[k], 1);
    c += cot[k] * (e.x() * ux + e.y() * uy);
    s += cot[k] * (e.x() * uy - e.y() * ux);
  }
  const double length = std::sqrt(c * c + s * s);
  return length > 0 ? Vector2d(c / length, s / length) : Vector2d(1, 0);
}

}  // namespace

RestTriangle RestOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double length = (b - a).norm();
  if (!(length > 0)) return {0, 0, 0};
  return {length, (b - a).dot(c - a) / length, (b - a).cross(c - a).norm() / length};
}

RestShape RestShapeOf(const Surface& s, const Chart& chart) {
  RestShape rest;
  for (const int f : chart.faces) {
    Vector3d p[3];
    for (int k = 0; k < 3; ++k) p[k] = s.points.row(s.faces(f, k));
    rest.triangles.push_back(RestOf(p[0], p[1], p[2]));
    std::array<double, 3> cot{};
    for (int k = 0; k < 3; ++k) {
      const Vector3d u = p[k] - p[(k + 2) % 3], v = p[(k + 1) % 3] - p[(k + 2) % 3];
      cot[k] = std::clamp(u.dot(v) / std::max(u.cross(v).norm(), 1e-300), 1e-2, 1e2);
    }
    rest.cotangents.push_back(cot);
    rest.area += s.areas[f];
  }
  return rest;
}

Eigen::SparseMatrix<double> ChartLaplacian(const Chart& chart, const RestShape& rest,
                                           const std::vector<int>& column, int size) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < std::ssize(chart.faces); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int a = column[chart.corners(i, k)], b = column[chart.corners(i, (k + 1) % 3)];
      const double w = rest.cotangents[i][k];
      if (a >= 0) entries.emplace_back(a, a, w);
      if (b >= 0) entries.emplace_back(b, b, w);
      if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), -w);
    }
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

double SignedArea(const UvsX2& uvs, const Chart& chart, int i) {
  const Vector2d p = uvs.row(chart.corners(i, 0)), q = uvs.row(chart.corners(i, 1)),
                 r = uvs.row(chart.corners(i, 2));
  return ((q - p).x() * (r - p).y() - (q - p).y() * (r - p).x()) / 2;
}

bool Upright(const Surface& s, const Chart& chart, const UvsX2& uvs, double least, double scale) {
  for (int i = 0; i < std::ssize(chart.faces); ++i)
    if (!(SignedArea(uvs, chart, i) > least * scale * scale * s.areas[chart.faces[i]]))
      return false;
  return true;
}

Sheet::Sheet(const Surface& surface, const Chart& chart, double hold)
    : chart_(chart), rest_(RestShapeOf(surface, chart)), hold_(hold) {
  const int count = SizeOf(chart.vertices);
  std::vector<int> column(count);
  for (int v = 0; v < count; ++v) column[v] = hold > 0 ? v : v - 1;
  const int size = hold > 0 ? count : count - 1;
  Eigen::SparseMatrix<double> matrix = ChartLaplacian(chart, rest_, column, size);
  if (hold > 0)
    for (const int v : chart.rim) matrix.coeffRef(v, v) += hold;
  solver_.Analyze(matrix);
  solver_.Factor(matrix);
}

double Sheet::Settle(double scale, const UvsX2& targets, UvsX2& uvs) const {
  const int count = static_cast<int>(uvs.rows());
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(count, 2);
  for (int i = 0; i < std::ssize(chart_.faces); ++i) {
    const RestTriangle& t = rest_.triangles[i];
    const Vector2d edges[3] = {scale * Vector2d(t.x1, 0), scale * Vector2d(t.x2 - t.x1, t.y2),
                               scale * Vector2d(-t.x2, -t.y2)};
    const Vector2d r = BestRotation(edges, rest_.cotangents[i], uvs, chart_.corners.row(i));
    for (int k = 0; k < 3; ++k) {
      const Vector2d e = rest_.cotangents[i][k] * edges[k];
      const Eigen::RowVector2d turned(r.x() * e.x() - r.y() * e.y(), r.y() * e.x() + r.x() * e.y());
      b.row(chart_.corners(i, (k + 1) % 3)) += turned;
      b.row(chart_.corners(i, k)) -= turned;
    }
  }
  if (!(hold_ > 0)) {
    const Eigen::MatrixXd solved = solver_.Solve(b.bottomRows(count - 1));
    const double change = (solved - (uvs.bottomRows(count - 1).rowwise() - uvs.row(0))).norm();
    uvs.row(0).setZero();
    uvs.bottomRows(count - 1) = solved;
    return change / std::max(solved.norm(), 1e-300);
  }
  for (std::size_t i = 0; i < chart_.rim.size(); ++i)
    b.row(chart_.rim[i]) += hold_ * targets.row(i);
  const Eigen::MatrixXd solved = solver_.Solve(b);
  const double change = (solved - uvs).norm() / std::max(solved.norm(), 1e-300);
  uvs = solved;
  return change;
}

}  // namespace keypose::texture
