#include "texture/bake/seam_levelling.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/cholesky.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::texture {
namespace {

using Eigen::RowVector3d;
using Eigen::Vector3f;
using Shares = std::vector<std::vector<LabelShare>>;

/// The value of shared/recipes.md, E.5 (after Lempitsky, Ivanov and Waechter et al.); no record of
/// other values.
struct SeamTuning {
  /// weight of the smoothness of shifts along an edge, in squared jumps between views
  KEYPOSE_TUNED(double, kSmooth, 0.1);
};
constexpr double kSmall = 1e-4;

/// The quadratic form, lower triangle, and its right-hand sides.
struct Quadratic {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right;

  /// Adds w (g_a - g_b + jump)^2.
  void AddDifference(int a, int b, double w, const RowVector3d& jump) {
    entries.emplace_back(a, a, w);
    entries.emplace_back(b, b, w);
    entries.emplace_back(std::max(a, b), std::min(a, b), -w);
    right.row(a) -= w * jump;
    right.row(b) += w * jump;
  }
  /// Adds w (g_a - target)^2.
  void AddTarget(int a, double w, const RowVector3d& target) {
    entries.emplace_back(a, a, w);
    right.row(a) += w * target;
  }
};

int Find(const std::vector<LabelShare>& list, int view) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].view == view) return static_cast<int>(i);
  return -1;
}

/// For each unknown (vertex, view): the view's colour and the mean of all views, both over those
/// faces of the ring where the view sees the face and agrees with the others. A highlight beside
/// the vertex would otherwise darken it.
struct RingColors {
  std::vector<RowVector3d> view, mean;
  std::vector<double> area;
};

RingColors MeasureRings(const Mesh& mesh, const std::vector<FaceViews>& faces, const Shares& shares,
                        const std::vector<int>& first) {
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  RingColors rings;
  rings.view.assign(first.back(), RowVector3d::Zero());
  rings.mean = rings.view;
  rings.area.assign(first.back(), 0);
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k)
      for (const LabelCandidate& c : faces[f].candidates) {
        const int v = mesh.faces(f, k), at = Find(shares[v], c.view);
        if (at < 0) continue;
        const double w = c.seen * c.agreement * std::max(areas[f], 1e-300);
        rings.view[first[v] + at] += w * c.linear.cast<double>().transpose();
        rings.mean[first[v] + at] += w * faces[f].mean.cast<double>().transpose();
        rings.area[first[v] + at] += w;
      }
  for (std::size_t i = 0; i < rings.area.size(); ++i)
    if (rings.area[i] > 0) {
      rings.view[i] /= rings.area[i];
      rings.mean[i] /= rings.area[i];
    }
  return rings;
}

}  // namespace

std::vector<std::vector<Shift>> LevelSeams(const Mesh& mesh, const std::vector<FaceViews>& faces,
                                           const std::vector<int>& labels, const Shares& shares,
                                           double to_mean) {
  std::vector<int> first(mesh.vertex_count() + 1, 0);
  for (int v = 0; v < mesh.vertex_count(); ++v) first[v + 1] = first[v] + SizeOf(shares[v]);
  const int unknowns = first.back();
  std::vector<std::vector<Shift>> shifts(mesh.vertex_count());
  if (unknowns == 0) return shifts;
  const RingColors rings = MeasureRings(mesh, faces, shares, first);
  Quadratic form;
  form.right = Eigen::MatrixXd::Zero(unknowns, 3);
  for (int i = 0; i < unknowns; ++i) {
    form.AddTarget(i, kSmall, RowVector3d::Zero());
    if (to_mean > 0) form.AddTarget(i, to_mean, rings.mean[i] - rings.view[i]);
  }
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int i = first[v]; i < first[v + 1]; ++i)
      for (int j = first[v]; j < i; ++j) form.AddDifference(i, j, 1, rings.view[i] - rings.view[j]);
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3 && labels[f] >= 0; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      // Each inner edge occurs twice, once from each side.
      form.AddDifference(first[a] + Find(shares[a], labels[f]),
                         first[b] + Find(shares[b], labels[f]), SeamTuning::kSmooth / 2,
                         RowVector3d::Zero());
    }
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(form.entries.begin(), form.entries.end());
  SparseCholesky solver;
  solver.Analyze(matrix);
  solver.Factor(matrix);
  const Eigen::MatrixXd solved = solver.Solve(form.right);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int i = first[v]; i < first[v + 1]; ++i)
      shifts[v].push_back({shares[v][i - first[v]].view, solved.row(i).cast<float>().transpose()});
  return shifts;
}

}  // namespace keypose::texture
