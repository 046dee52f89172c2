#include "deform/poisson/poisson.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "core/values/union_find.h"
#include "deform/poisson/poisson_impl.h"

namespace keypose {

namespace {

// Chosen on the bends and twists with known answers (docs/results/interpolation.md); sensitivity:
// docs/results/sensitivity.md.
struct PoissonTuning {
  KEYPOSE_TUNED(double, kScreening, 0.1);  // 1 / sqrt(kappa), over the mean diagonal of the keys
};

constexpr double kSliverTriangle = 1e-6;  // as in FaceMapsOf

std::vector<int> LowestVertexOfPart(Eigen::Index vertex_count, const FacesX3& faces) {
  UnionFind joined(vertex_count);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) joined.Join(faces(f, 0), faces(f, k));
  std::vector<int> lowest(vertex_count);
  for (int i = 0; i < static_cast<int>(vertex_count); ++i) lowest[i] = joined.Find(i);
  return lowest;
}

/// Half the cotangents of a triangle's corners, and its area. False when it has no area.
bool Measure(const PointsX3& p, const FacesX3& faces, Eigen::Index f, EdgeWeights& half_cotangents,
             double& area) {
  const Eigen::Vector3d p0 = p.row(faces(f, 0)), p1 = p.row(faces(f, 1)), p2 = p.row(faces(f, 2));
  const Eigen::Vector3d e0 = p2 - p1, e1 = p0 - p2, e2 = p1 - p0;
  const double doubled = e1.cross(e2).norm();
  if (!(doubled >
        kSliverTriangle * std::max({e0.squaredNorm(), e1.squaredNorm(), e2.squaredNorm()})))
    return false;
  half_cotangents = {-0.5 * e1.dot(e2) / doubled, -0.5 * e2.dot(e0) / doubled,
                     -0.5 * e0.dot(e1) / doubled};
  area = 0.5 * doubled;
  return true;
}

}  // namespace

EdgeBatch::EdgeBatch(Eigen::Index faces, int frame_count)
    : frames(frame_count), stride((frame_count + kVectorWidth - 1) / kVectorWidth * kVectorWidth) {
  const std::size_t size = static_cast<std::size_t>(faces) * 6 * stride;
  // Columns without a frame are summed as well, so they must be initialised.
  values_ = frames == stride ? std::make_unique_for_overwrite<double[]>(size)
                             : std::make_unique<double[]>(size);
}

EdgeBatch::EdgeBatch(std::span<const int> faces, int frame_count)
    : EdgeBatch(std::ssize(faces), frame_count) {
  listed = faces;
  std::fill_n(values_.get(), faces.size() * 6 * stride, 0.0);
}

FrameRows::FrameRows(Eigen::Index vertex_count, int frame_count)
    : vertices(vertex_count),
      frames(frame_count),
      stride((frame_count + kVectorWidth - 1) / kVectorWidth * kVectorWidth),
      values(std::make_unique_for_overwrite<double[]>(static_cast<std::size_t>(vertices) * 3 *
                                                      stride)) {}

void EdgeBatch::Set(Eigen::Index face, int frame, const Eigen::Matrix<double, 3, 2>& edges) {
  for (int c = 0; c < 6; ++c) Face(face)[c * stride + frame] = edges.data()[c];
}

PoissonSystem::Impl::Impl(const KeyRefs& keys, const FacesX3& f, const PoissonOptions& o)
    : n(keys.empty() ? 0 : keys[0].get().rows()), faces(f), options(o) {
  if (keys.empty()) throw InputError("interpolate: no keys");
  for (const PointsX3& key : keys)
    if (key.rows() != n)
      throw InputError(
          "interpolate: the keys have different numbers of vertices; register all poses from one "
          "template");
  FindParts();
  BuildIncidence();
  Weigh(keys);
  Assemble();
}

void PoissonSystem::Impl::FindParts() {
  lowest = LowestVertexOfPart(n, faces);
  parts.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) parts[i] = lowest[i] == i ? part_count++ : parts[lowest[i]];
  part_size.assign(part_count, 0);
  for (int part : parts) ++part_size[part];
}

void PoissonSystem::Impl::BuildIncidence() {
  first_corner.assign(n + 1, 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++first_corner[faces(f, k) + 1];
  std::partial_sum(first_corner.begin(), first_corner.end(), first_corner.begin());
  corners.resize(3 * faces.rows());
  std::vector<int> at(first_corner.begin(), first_corner.end() - 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) corners[at[faces(f, k)]++] = static_cast<int>(3 * f + k);
}

void PoissonSystem::Impl::Weigh(const KeyRefs& keys) {
  weights.resize(faces.rows());
  area.setZero(faces.rows());
  ParallelBlocks(faces.rows(), 1024, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) {
      EdgeWeights sum = {0, 0, 0};
      bool good = true;
      for (const PointsX3& key : keys) {
        EdgeWeights w;
        double a = 0;
        good = Measure(key, faces, f, w, a) && good;
        if (!good) break;
        for (int k = 0; k < 3; ++k) sum[k] += w[k];
        area[f] += a;
      }
      // A face without area has no cotangents. Small weights of an equilateral triangle keep its
      // corners connected.
      weights[f] = good ? sum : EdgeWeights{1e-3, 1e-3, 1e-3};
      if (!good) area[f] = 0;
    }
  });
  double diagonal = 0;
  for (const PointsX3& key : keys)
    diagonal += BoundingDiagonal(key) / static_cast<double>(keys.size());
  screening_length =
      std::max(PoissonTuning::kScreening * diagonal, std::numeric_limits<double>::min());
}

Eigen::SparseMatrix<double> PoissonSystem::Impl::LowerLaplacian() const {
  // Column j: its diagonal, then its neighbours of higher index, gathered from its own faces in
  // order. So no two threads share a sum.
  using Entry = std::pair<int, double>;
  const auto column = [&](Eigen::Index j, std::vector<Entry>& entries) {
    entries.assign(1, {static_cast<int>(j), 0.0});
    for (int at = first_corner[j]; at < first_corner[j + 1]; ++at) {
      const int f = corners[at] / 3, k = corners[at] % 3;
      for (int side = 1; side <= 2; ++side) {
        const int other = faces(f, (k + side) % 3);
        // weight of the edge between them, opposite the third corner
        const double w = weights[f][(k + 3 - side) % 3];
        if (other == j) continue;
        entries[0].second += w;
        if (other < j) continue;
        auto it = std::find_if(entries.begin() + 1, entries.end(),
                               [&](const Entry& e) { return e.first >= other; });
        if (it == entries.end() || it->first != other) it = entries.insert(it, {other, 0.0});
        it->second -= w;
      }
    }
  };
  std::vector<std::vector<Entry>> blocks((n + 1023) / 1024);
  std::vector<int> start(n + 1, 0);
  ParallelBlocks(n, 1024, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Entry> entries;
    for (std::int64_t j = begin; j < end; ++j) {
      column(j, entries);
      start[j + 1] = SizeOf(entries);
      blocks[begin / 1024].insert(blocks[begin / 1024].end(), entries.begin(), entries.end());
    }
  });
  std::partial_sum(start.begin(), start.end(), start.begin());
  Eigen::SparseMatrix<double> h(n, n);
  h.resizeNonZeros(start[n]);
  std::copy(start.begin(), start.end(), h.outerIndexPtr());
  Eigen::Index at = 0;
  for (const auto& block : blocks)
    for (const auto& [row, value] : block) {
      h.innerIndexPtr()[at] = row;
      h.valuePtr()[at++] = value;
    }
  return h;
}

void PoissonSystem::Impl::Assemble() {
  Eigen::SparseMatrix<double> h = LowerLaplacian();
  mass.setZero(n);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) mass[faces(f, k)] += area[f] / 3;
  mass = mass.cwiseMax(1e-9 * mass.sum() / static_cast<double>(std::max<Eigen::Index>(1, n)) +
                       std::numeric_limits<double>::min());
  Eigen::VectorXd diagonal(n);
  for (Eigen::Index j = 0; j < n; ++j) diagonal[j] = h.valuePtr()[h.outerIndexPtr()[j]];
  const double ground = std::max(diagonal.cwiseAbs().mean(), 1e-12);
  for (Eigen::Index j = 0; j < n; ++j)
    if (lowest[j] == j) h.valuePtr()[h.outerIndexPtr()[j]] += ground;
  solver.Analyze(h, options.dissected);
  CutPatches();
  if (!options.screened) {
    solver.Factor(h);
    return;
  }
  Eigen::SparseMatrix<double> screened_h = h;
  const double kappa = Kappa();
  for (Eigen::Index j = 0; j < n; ++j)
    screened_h.valuePtr()[h.outerIndexPtr()[j]] = diagonal[j] + kappa * mass[j];
  screened = solver.SameAnalysis();
  ParallelFor(2, [&](std::int64_t k) { k == 0 ? solver.Factor(h) : screened.Factor(screened_h); });
}

PoissonSystem::PoissonSystem(const KeyRefs& keys, const FacesX3& faces,
                             const std::vector<ConstraintRow>& rows, const PoissonOptions& options)
    : impl_(std::make_unique<Impl>(keys, faces, options)) {
  impl_->AcceptRows(rows);
}
PoissonSystem::~PoissonSystem() = default;
PoissonSystem::PoissonSystem(PoissonSystem&&) noexcept = default;

int PoissonSystem::vertex_count() const { return static_cast<int>(impl_->n); }
const FacesX3& PoissonSystem::faces() const { return impl_->faces; }
int PoissonSystem::patch_count() const { return SizeOf(impl_->patch_begin) - 1; }
std::span<const int> PoissonSystem::FacesOfPatch(int patch) const {
  return impl_->FacesOfPatch(patch);
}
const std::vector<int>& PoissonSystem::parts() const { return impl_->parts; }
int PoissonSystem::part_count() const { return impl_->part_count; }
const Eigen::VectorXd& PoissonSystem::face_areas() const { return impl_->area; }
const std::vector<ConstraintRow>& PoissonSystem::rows() const { return impl_->rows; }
const std::vector<int>& PoissonSystem::row_sources() const { return impl_->sources; }
const std::vector<std::string>& PoissonSystem::dropped_rows() const { return impl_->dropped; }
double PoissonSystem::screening_length() const { return impl_->screening_length; }

RowTargets PoissonSystem::RowsAt(const PointsX3& points) const {
  RowTargets values = RowTargets::Zero(std::ssize(impl_->rows), 3);
  for (std::size_t r = 0; r < impl_->rows.size(); ++r)
    for (const auto& [vertex, weight] : impl_->rows[r].terms)
      values.row(r) += weight * points.row(vertex);
  return values;
}

void PoissonSystem::Impl::Fit(FrameRows& solved, const std::vector<RowTargets>& targets,
                              std::vector<PointsX3>& frames) const {
  for (const RowTargets& t : targets)
    if (t.rows() != std::ssize(rows))
      throw InputError("interpolate: one target a constraint row is needed");
  if (SizeOf(targets) != solved.frames)
    throw InputError("interpolate: one set of targets a frame is needed");
  if (coupled == 0) solver.SolveRows(solved.values.get(), 3 * solved.stride);
  frames.resize(targets.size());
  for (PointsX3& frame : frames) frame.resize(n, 3);
  // Row by row: a row has a number of each frame, so that each is loaded once.
  constexpr int kRowsTogether = 512;
  ParallelBlocks(n, kRowsTogether, [&](std::int64_t begin, std::int64_t end) {
    for (int t = 0; t < solved.frames; ++t) {
      double* frame = frames[t].data();
      for (std::int64_t r = begin; r < end; ++r) {
        const double* row = solved.Row(r) + t;
        double* point = frame + 3 * static_cast<std::ptrdiff_t>(solver.unknowns()[r]);
        point[0] = row[0];
        point[1] = row[solved.stride];
        point[2] = row[2 * solved.stride];
      }
    }
  });
  if (coupled > 0) {
    Eigen::MatrixXd x(n, 3 * solved.frames);
    for (int t = 0; t < solved.frames; ++t) x.middleCols<3>(3 * t) = frames[t];
    SolveWithRows(x, targets);
    for (int t = 0; t < solved.frames; ++t) frames[t] = x.middleCols<3>(3 * t);
  }
  ParallelFor(std::ssize(frames), [&](std::int64_t t) { CentreFreeParts(frames[t], targets[t]); });
}

std::vector<PointsX3> PoissonSystem::Solve(const EdgeBatch& edges,
                                           const std::vector<RowTargets>& targets,
                                           const std::vector<Eigen::Matrix3d>& turns) const {
  FrameRows rows(impl_->n, edges.frames);
  ParallelFor(std::ssize(impl_->patch_begin) - 1, [&](std::int64_t patch) {
    for (int first = 0; first < edges.frames; first += kVectorWidth)
      impl_->Gather(static_cast<int>(patch), edges, turns.empty() ? nullptr : turns.data(), first,
                    rows);
  });
  std::vector<PointsX3> poses;
  impl_->Fit(rows, targets, poses);
  return poses;
}

std::vector<PointsX3> PoissonSystem::Solve(int frames, const FillEdges& fill,
                                           const std::vector<RowTargets>& targets,
                                           const std::vector<Eigen::Matrix3d>& turns) const {
  FrameRows rows;
  std::vector<PointsX3> poses;
  SolveInto(frames, fill, targets, turns, rows, poses);
  return poses;
}

void PoissonSystem::SolveInto(int frames, const FillEdges& fill,
                              const std::vector<RowTargets>& targets,
                              const std::vector<Eigen::Matrix3d>& turns, FrameRows& rows,
                              std::vector<PointsX3>& poses) const {
  if (rows.vertices != impl_->n || rows.frames != frames) rows = FrameRows(impl_->n, frames);
  impl_->RightHandSide(fill, turns, rows);
  impl_->Fit(rows, targets, poses);
}

PointsX3 PoissonSystem::SolveOne(const FillOneFrame& fill, const RowTargets& target,
                                 const Eigen::Matrix3d& turn) const {
  std::vector<double> rows = impl_->OneRightHandSide(fill, turn);
  impl_->solver.SolveFour(rows.data());
  PointsX3 pose(impl_->n, 3);
  for (Eigen::Index r = 0; r < impl_->n; ++r)
    pose.row(impl_->solver.unknowns()[r]) = Eigen::Map<const Eigen::RowVector3d>(&rows[4 * r]);
  impl_->CentreFreeParts(pose, target);
  return pose;
}

bool PoissonSystem::IsFree() const { return impl_->coupled == 0; }
const std::vector<int>& PoissonSystem::row_of() const { return impl_->solver.rows(); }

FrameRows PoissonSystem::SolveFree(int frames, const FillEdges& fill) const {
  FrameRows rows(impl_->n, frames);
  impl_->RightHandSide(fill, {}, rows);
  impl_->solver.SolveRows(rows.values.get(), 3 * rows.stride);
  return rows;
}

Eigen::MatrixXd PoissonSystem::SolveScreened(const Eigen::MatrixXd& b) const {
  Eigen::MatrixXd x = b;
  impl_->screened.SolveInPlace(x);
  return x;
}

Eigen::MatrixXd PoissonSystem::SmoothOverVertices(const Eigen::MatrixXd& face_values,
                                                  int passes) const {
  const Impl& s = *impl_;
  const double kappa = s.Kappa();
  Eigen::MatrixXd x(s.n, face_values.cols());
  ParallelFor(
      s.n,
      [&](std::int64_t i) {
        Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(face_values.cols());
        double area = 0;
        for (int at = s.first_corner[i]; at < s.first_corner[i + 1]; ++at) {
          sum += s.area[s.corners[at] / 3] * face_values.row(s.corners[at] / 3);
          area += s.area[s.corners[at] / 3];
        }
        x.row(i) = sum * (area > 0 ? kappa * s.mass[i] / area : 0.0);
      },
      1024);
  s.screened.SolveInPlace(x);
  for (int pass = 1; pass < passes; ++pass) {
    x = (kappa * s.mass).asDiagonal() * x;
    s.screened.SolveInPlace(x);
  }
  return x;
}

}  // namespace keypose
