#include "interpolate/surface/paper_arap.h"

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

#include "core/numbers/cholesky.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/maps/key_pair.h"

namespace keypose::interpolation {

namespace {

/// Rows [p 1] of a triangle's corners and its fourth vertex.
Eigen::Matrix4d SurfaceTetrahedron(const PointsX3& p, const FacesX3& faces, Eigen::Index f,
                                   double& area) {
  const Eigen::Vector3d a = p.row(faces(f, 0)), b = p.row(faces(f, 1)), c = p.row(faces(f, 2));
  const Eigen::Vector3d n = (b - a).cross(c - a);
  area = 0.5 * n.norm();
  const Eigen::Vector3d d = (a + b + c) / 3 + n / std::sqrt(n.norm());
  Eigen::Matrix4d rows;
  rows << a.transpose(), 1, b.transpose(), 1, c.transpose(), 1, d.transpose(), 1;
  return rows;
}

}  // namespace

struct PaperInterpolator::Impl {
  struct Cell {
    Eigen::Vector4i ids;
    Eigen::Matrix<double, 3, 4> inverse;  // V_T^*
    Eigen::Matrix3d stretch;              // S
    Eigen::Vector3d turn;                 // rotation vector of R^T (columns)
    double area;
  };

  void MakeCells(const FacesX3& faces) {
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      Cell cell;
      double area_u = 0;
      const Eigen::Matrix4d from = SurfaceTetrahedron(v, faces, f, cell.area),
                            to = SurfaceTetrahedron(u, faces, f, area_u);
      if (!(cell.area > 0) || !(area_u > 0) || !from.allFinite() || !to.allFinite())
        throw InputError(
            "interpolate: face " + std::to_string(f) +
            " has no area in one of the keys; the paper's method cannot map it, use --method arap");
      cell.ids << faces(f, 0), faces(f, 1), faces(f, 2), static_cast<int>(v.rows() + f);
      cell.inverse = from.inverse().topRows<3>();
      const Eigen::Matrix3d a = cell.inverse * to.leftCols<3>();
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
      cell.stretch = svd.matrixU() * svd.singularValues().asDiagonal() * svd.matrixU().transpose();
      cell.turn = LogOf((svd.matrixU() * svd.matrixV().transpose()).transpose());
      cells.push_back(cell);
    }
  }

  void FindParts(Eigen::Index n, const FacesX3& faces) {
    part.resize(n);
    std::iota(part.begin(), part.end(), 0);
    for (bool changed = true; changed;) {
      changed = false;
      for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const int low = std::min({part[faces(f, 0)], part[faces(f, 1)], part[faces(f, 2)]});
        for (int k = 0; k < 3; ++k)
          if (part[faces(f, k)] != low) {
            part[faces(f, k)] = low;
            changed = true;
          }
      }
    }
  }

  void Factor() {
    const int n = static_cast<int>(v.rows());
    std::vector<Eigen::Triplet<double>> triplets;
    double trace = 0;
    for (const Cell& cell : cells) {
      const Eigen::Matrix4d h = cell.area * cell.inverse.transpose() * cell.inverse;
      trace += h.trace();
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
          if (cell.ids[a] >= cell.ids[b]) triplets.emplace_back(cell.ids[a], cell.ids[b], h(a, b));
    }
    const int unknowns = n + SizeOf(cells);
    for (int i = 0; i < n; ++i)
      if (part[i] == i) triplets.emplace_back(i, i, trace / unknowns);
    Eigen::SparseMatrix<double> h(unknowns, unknowns);
    h.setFromTriplets(triplets.begin(), triplets.end());
    solver.Analyze(h);
    solver.Factor(h);
  }

  PointsX3 v, u;
  std::vector<Cell> cells;
  std::vector<int> part;  // lowest vertex of the connected part
  SparseCholesky solver;
};

PaperInterpolator::PaperInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces)
    : impl_(std::make_unique<Impl>()) {
  RequireKeys(v, u, faces);
  impl_->v = v;
  impl_->u = u;
  impl_->MakeCells(faces);
  impl_->FindParts(v.rows(), faces);
  impl_->Factor();
}

PaperInterpolator::~PaperInterpolator() = default;
PaperInterpolator::PaperInterpolator(PaperInterpolator&&) noexcept = default;

PointsX3 PaperInterpolator::At(double t) const {
  const Eigen::Index n = impl_->v.rows();
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(n + std::ssize(impl_->cells), 3);
  for (const Impl::Cell& cell : impl_->cells) {
    const Eigen::Matrix3d a = ((1 - t) * Eigen::Matrix3d::Identity() + t * cell.stretch) *
                              ExpOf(t * cell.turn).transpose();
    const Eigen::Matrix<double, 4, 3> rows = cell.area * cell.inverse.transpose() * a;
    for (int k = 0; k < 4; ++k) g.row(cell.ids[k]) += rows.row(k);
  }
  PointsX3 points = impl_->solver.Solve(g).topRows(n);
  PointsX3 shift = PointsX3::Zero(n, 3);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    shift.row(impl_->part[i]) += (1 - t) * impl_->v.row(i) + t * impl_->u.row(i) - points.row(i);
    count[impl_->part[i]] += 1;
  }
  for (Eigen::Index i = 0; i < n; ++i)
    points.row(i) += shift.row(impl_->part[i]) / count[impl_->part[i]];
  return points;
}

}  // namespace keypose::interpolation
