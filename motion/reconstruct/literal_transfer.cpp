#include "motion/reconstruct/literal_transfer.h"

#include <Eigen/SparseCore>
#include <string>

#include "core/numbers/cholesky.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"
#include "motion/fields/mark_fields.h"
#include "motion/fields/marks.h"

namespace keypose::motion {

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// The cotangent Laplacian of one triangle, 3 x 3.
Eigen::Matrix3d LaplacianOf(const PointsX3& points, const FacesX3& faces, Eigen::Index f) {
  const Eigen::Vector3d w = HalfCotangents(points, faces, f);
  Eigen::Matrix3d l;
  l << w[1] + w[2], -w[2], -w[1],  //
      -w[2], w[0] + w[2], -w[0],   //
      -w[1], -w[0], w[0] + w[1];
  return l;
}

Eigen::SparseMatrix<double> Assembled(Eigen::Index size, const Triplets& entries) {
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

struct LiteralTransfer::Impl {
  void FixMarkedVertices(const std::vector<int>& marked_faces);
  void Factor();
  Eigen::MatrixXd VertexFields(const Eigen::MatrixXd& values) const;

  PointsX3 points;
  FacesX3 faces;
  std::vector<int> marked, free_place;
  std::vector<std::vector<int>> marks_at;  // of each vertex
  std::vector<std::vector<int>> marks_on;  // of each face
  int free_count = 0;
  Eigen::SparseMatrix<double> laplacian;
  SparseCholesky fields, positions;
};

void LiteralTransfer::Impl::FixMarkedVertices(const std::vector<int>& marked_faces) {
  marked = marked_faces;
  marks_at.resize(points.rows());
  marks_on.resize(faces.rows());
  for (int k = 0; k < SizeOf(marked); ++k) {
    marks_on[marked[k]].push_back(k);
    for (int c = 0; c < 3; ++c) marks_at[faces(marked[k], c)].push_back(k);
  }
  UnionFind joined(points.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) joined.Join(faces(f, 0), faces(f, k));
  for (int i = 0; i < static_cast<int>(points.rows()); ++i)
    if (joined.Find(i) != 0)
      throw InputError("transfer: vertex " + std::to_string(i) +
                       " of the target is not connected with the others, of which the paper says "
                       "nothing; use --method paper or auto");
  free_place.assign(points.rows(), -1);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (marks_at[i].empty()) free_place[i] = free_count++;
}

void LiteralTransfer::Impl::Factor() {
  Triplets all, free;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    if (HasNoArea(points, faces, static_cast<int>(f)))
      throw InputError("transfer: triangle " + std::to_string(f) +
                       " of the target has no area, so that the paper's Laplacian is not defined; "
                       "use --method auto, or repair the mesh with keypose cleanup");
    const Eigen::Matrix3d l = LaplacianOf(points, faces, f);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const int i = faces(f, a), j = faces(f, b);
        all.emplace_back(i, j, l(a, b));
        if (free_place[i] >= 0 && free_place[j] >= 0)
          free.emplace_back(free_place[i], free_place[j], l(a, b));
      }
  }
  laplacian = Assembled(points.rows(), all);
  all.emplace_back(0, 0, 1.0);
  const Eigen::SparseMatrix<double> grounded = Assembled(points.rows(), all);
  positions.Analyze(grounded);
  positions.Factor(grounded);
  if (free_count == 0) return;
  const Eigen::SparseMatrix<double> inner = Assembled(free_count, free);
  fields.Analyze(inner);
  fields.Factor(inner);
}

/// @param values  M x C, of the marks @return V x C
Eigen::MatrixXd LiteralTransfer::Impl::VertexFields(const Eigen::MatrixXd& values) const {
  Eigen::MatrixXd field = Eigen::MatrixXd::Zero(points.rows(), values.cols());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (int k : marks_at[i])
      field.row(i) += values.row(k) / static_cast<double>(marks_at[i].size());
  if (free_count == 0) return field;
  const Eigen::MatrixXd pull = laplacian * field;
  Eigen::MatrixXd rhs(free_count, values.cols());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (free_place[i] >= 0) rhs.row(free_place[i]) = -pull.row(i);
  const Eigen::MatrixXd inner = fields.Solve(rhs);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (free_place[i] >= 0) field.row(i) = inner.row(free_place[i]);
  return field;
}

LiteralTransfer::LiteralTransfer(const PointsX3& points, const FacesX3& faces,
                                 const std::vector<int>& marked_faces)
    : impl_(std::make_unique<Impl>()) {
  impl_->points = points;
  impl_->faces = faces;
  impl_->FixMarkedVertices(marked_faces);
  impl_->Factor();
}
LiteralTransfer::~LiteralTransfer() = default;

std::vector<Eigen::Quaterniond> LiteralTransfer::FaceRotations(
    const std::vector<Eigen::Quaterniond>& rotations) const {
  Eigen::MatrixXd values(std::ssize(rotations), 4);
  for (int k = 0; k < SizeOf(rotations); ++k)
    values.row(k) = rotations[k].coeffs().transpose();  // x, y, z, w
  const Eigen::MatrixXd field = impl_->VertexFields(values);
  std::vector<Eigen::Quaterniond> result(impl_->faces.rows());
  for (Eigen::Index f = 0; f < impl_->faces.rows(); ++f) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int c = 0; c < 3; ++c) sum += field.row(impl_->faces(f, c)).transpose() / 3;
    const std::vector<int>& own = impl_->marks_on[f];
    if (!own.empty()) sum.setZero();
    for (int k : own) sum += values.row(k).transpose() / static_cast<double>(own.size());
    result[f] = Eigen::Quaterniond(sum.normalized());
  }
  return result;
}

PointsX3 LiteralTransfer::Pose(const std::vector<Eigen::Quaterniond>& rotations) const {
  const Impl& s = *impl_;
  const std::vector<Eigen::Quaterniond> turned = FaceRotations(rotations);
  PointsX3 fragmented(3 * s.faces.rows(), 3);
  Eigen::MatrixXd differential(3 * s.faces.rows(), 3);
  for (Eigen::Index f = 0; f < s.faces.rows(); ++f) {
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (int c = 0; c < 3; ++c) centre += s.points.row(s.faces(f, c)) / 3;
    for (int c = 0; c < 3; ++c)
      fragmented.row(3 * f + c) =
          centre + (turned[f] * (s.points.row(s.faces(f, c)) - centre).transpose()).transpose();
    differential.middleRows<3>(3 * f) =
        LaplacianOf(s.points, s.faces, f) * fragmented.middleRows<3>(3 * f);
  }
  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(s.points.rows(), 3);
  for (Eigen::Index f = 0; f < s.faces.rows(); ++f)
    for (int c = 0; c < 3; ++c) reduced.row(s.faces(f, c)) += differential.row(3 * f + c);
  reduced.row(0) += s.points.row(0);
  return s.positions.Solve(reduced);
}

}  // namespace keypose::motion
