#include "motion/reconstruct/frame_solver.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "core/rotations.h"
#include "core/size_of.h"
#include "deform/solvers/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::motion {

namespace {

constexpr int kLanes = 4;

/// Marks and weights of one row.
struct WeightedRow {
  const int* mark;
  const double* weight;
  int count;
};
inline WeightedRow RowAt(const WeightRows& rows, int at) {
  const int begin = rows.begin[at];
  return {rows.mark.data() + begin, rows.weight.data() + begin, rows.begin[at + 1] - begin};
}

/// Four frames of the edges of a patch.
struct TurnJob {
  const WeightRows *vertex_rows, *own_rows;
  const int* own_row;    // of each face: its row of own_rows, or -1
  const double* values;  // of the marks: [mark][component][frame]
  int components;
  bool quaternions, remainders;
  const double* edges;
  const int *vertices, *corners;  // of the patch: its vertices, and its faces' corners among them
  int vertex_count;
  const int* listed;
  int count;
  double* fields;  // room for [vertex][component][frame]
  double* out;
};

/// One frame of the edges of some faces.
struct OneTurnJob {
  const WeightRows* own_rows;
  const int* own_row;
  const double* values;  // of the marks: [mark][component], components of the turn 0 .. 3, of the
                         // remainder 4 .. 7
  int components;
  bool quaternions, remainders;
  const double* edges;
  const double* fields;  // of all vertices: [vertex][component]
  const int* corners;    // of all faces
  const int* listed;
  int count;
  double* out;  // eight numbers a face
};

}  // namespace

namespace plain {
using namespace keypose::plain;
#include "motion/reconstruct/turned_edges.inc"
}  // namespace plain
KEYPOSE_FUSED_BEGIN
namespace fused {
using namespace keypose::fused;
#include "motion/reconstruct/turned_edges.inc"
}  // namespace fused
KEYPOSE_FUSED_END

namespace {

Eigen::Matrix3d SymmetricOf(const Eigen::VectorXd& s) {
  Eigen::Matrix3d m;
  m << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  return m;
}

Eigen::Matrix3d ExpOfSymmetric(const Eigen::Matrix3d& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
  return solver.eigenvectors() * solver.eigenvalues().array().exp().matrix().asDiagonal() *
         solver.eigenvectors().transpose();
}

using Row = std::vector<std::pair<int, double>>;

/// The weighted sum of the marks' rows.
Eigen::VectorXd MixedRow(const Row& row, const Eigen::MatrixXd& values) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(values.cols());
  for (const auto& [mark, weight] : row) sum += weight * values.row(mark).transpose();
  return sum;
}

/// The map that the fields ask at a row of weights, without the body.
Eigen::Matrix3d MapAt(const Row& row, const FrameFields& frame) {
  Eigen::Matrix3d map;
  if (frame.quaternions.size() > 0) {
    const Eigen::Vector4d q = MixedRow(row, frame.quaternions).normalized();
    map = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  } else {
    map = ExpOf(MixedRow(row, frame.turns));
    if (frame.remainders.size() > 0) map = map * ExpOf(MixedRow(row, frame.remainders));
  }
  if (frame.log_stretches.size() > 0)
    map = map * ExpOfSymmetric(SymmetricOf(MixedRow(row, frame.log_stretches)));
  return map;
}

/// The marks' values of four frames, [mark][component][frame]; the last frame repeats at the end.
std::vector<double> ValuesOf(const std::vector<FrameFields>& frames, int first, int components) {
  const bool quaternions = frames[first].quaternions.size() > 0;
  const Eigen::Index marks =
      quaternions ? frames[first].quaternions.rows() : frames[first].turns.rows();
  std::vector<double> values(marks * components * kLanes, 0.0);
  for (int lane = 0; lane < kLanes; ++lane) {
    const FrameFields& frame = frames[std::min(first + lane, SizeOf(frames) - 1)];
    for (Eigen::Index k = 0; k < marks; ++k)
      for (int c = 0; c < components; ++c)
        values[(k * components + c) * kLanes + lane] = quaternions ? frame.quaternions(k, c)
                                                       : c < 3     ? frame.turns(k, c)
                                                       : frame.remainders.size() > 0
                                                           ? frame.remainders(k, c - 3)
                                                           : 0.0;
  }
  return values;
}

bool AnyOf(const std::vector<FrameFields>& frames, bool (*has)(const FrameFields&)) {
  return std::any_of(frames.begin(), frames.end(), has);
}

}  // namespace

FrameFields FrameFields::Quaternions(const std::vector<Eigen::Quaterniond>& agreeing) {
  FrameFields frame;
  frame.quaternions.resize(std::ssize(agreeing), 4);
  for (int k = 0; k < SizeOf(agreeing); ++k)
    frame.quaternions.row(k) << agreeing[k].w(), agreeing[k].x(), agreeing[k].y(), agreeing[k].z();
  return frame;
}

FrameFields FrameFields::Turns(const MarkTurns& turns) {
  FrameFields frame;
  frame.body = turns.body;
  frame.turns = turns.turns;
  frame.remainders = turns.remainders;
  return frame;
}

PoissonSystem FrameSolver::SystemOf(const PointsX3& rest, const FacesX3& faces, bool screened) {
  return PoissonSystem({rest}, faces, {}, {screened, true});
}

FrameSolver::FrameSolver(const PointsX3& rest, const FacesX3& faces, const MarkFields& fields,
                         PoissonSystem system)
    : rest_(rest), fields_(fields), system_(std::move(system)) {
  edges_.reserve(6 * faces.rows() + 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k)
      for (int c = 0; c < 3; ++c) edges_.push_back(rest(faces(f, k), c) - rest(faces(f, 0), c));
  edges_.push_back(0);
  std::vector<int> place(rest.rows(), -1);
  for (int p = 0; p < system_.patch_count(); ++p) {
    Patch patch;
    for (const int f : system_.FacesOfPatch(p))
      for (int k = 0; k < 3; ++k) {
        int& at = place[faces(f, k)];
        if (at < 0) at = SizeOf(patch.vertices), patch.vertices.push_back(faces(f, k));
        patch.corners.push_back(at);
      }
    for (const int i : patch.vertices) place[i] = -1;
    patches_.push_back(std::move(patch));
  }
}

std::vector<PointsX3> FrameSolver::Solve(const std::vector<FrameFields>& frames) const {
  Space space;
  Solve(frames, space);
  return std::move(space.poses);
}

PointsX3 FrameSolver::SolveOne(const FrameFields& frame) const {
  const bool quaternions = frame.quaternions.size() > 0, remainders = frame.remainders.size() > 0;
  const int components = remainders ? 8 : 4;
  const Eigen::MatrixXd& turns = quaternions ? frame.quaternions : Eigen::MatrixXd(frame.turns);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values =
      Eigen::MatrixXd::Zero(turns.rows(), components);
  values.leftCols(turns.cols()) = turns;
  if (remainders) values.middleCols<3>(4) = frame.remainders;
  const bool stretched = frame.log_stretches.size() > 0;
  const FacesX3& faces = system_.faces();
  std::vector<double> at_vertices(stretched ? 0 : rest_.rows() * components);
  constexpr int kVerticesTogether = 2048;
  ParallelBlocks(
      stretched ? 0 : rest_.rows(), kVerticesTogether, [&](std::int64_t begin, std::int64_t end) {
        const auto mix = HasFused() ? fused::MixVerticesOfOneFrame : plain::MixVerticesOfOneFrame;
        mix(fields_.vertices(), static_cast<int>(begin), static_cast<int>(end), values.data(),
            components, at_vertices.data());
      });
  const auto fill = [&](int patch, double* edges) {
    const std::span<const int> listed = system_.FacesOfPatch(patch);
    if (stretched) {
      for (std::size_t k = 0; k < listed.size(); ++k) {
        const Eigen::Map<const Eigen::Matrix<double, 3, 2>> rest(edges_.data() + 6 * listed[k]);
        Eigen::Map<Eigen::Matrix<double, 4, 2>> out(edges + 8 * k);
        out << MapAt(fields_.RowOfFace(listed[k]), frame) * rest, Eigen::RowVector2d::Zero();
      }
      return;
    }
    const OneTurnJob job{&fields_.own_rows(), fields_.own_row().data(),
                         values.data(),       components,
                         quaternions,         remainders,
                         edges_.data(),       at_vertices.data(),
                         faces.data(),        listed.data(),
                         SizeOf(listed),      edges};
    HasFused() ? fused::TurnEdgesOfOneFrame(job) : plain::TurnEdgesOfOneFrame(job);
  };
  return system_.SolveOne(fill, RowTargets::Zero(std::ssize(system_.rows()), 3), frame.body);
}

void FrameSolver::Solve(const std::vector<FrameFields>& frames, Space& space) const {
  const bool quaternions = frames[0].quaternions.size() > 0;
  const bool remainders =
      AnyOf(frames, [](const FrameFields& frame) { return frame.remainders.size() > 0; });
  const bool stretched =
      AnyOf(frames, [](const FrameFields& frame) { return frame.log_stretches.size() > 0; });
  const int components = quaternions ? 4 : remainders ? 6 : 3;
  std::vector<std::vector<double>> values;
  for (int first = 0; first < SizeOf(frames); first += kLanes)
    values.push_back(ValuesOf(frames, first, components));
  const auto fill = [&](int first, EdgeBatch& edges) {
    if (stretched) {
      for (int k = 0; k < SizeOf(edges.listed); ++k) {
        const int face = edges.listed[k];
        const Row row = fields_.RowOfFace(face);
        const Eigen::Map<const Eigen::Matrix<double, 3, 2>> rest(edges_.data() + 6 * face);
        for (int t = 0; t < edges.frames; ++t)
          edges.Set(k, t, MapAt(row, frames[first + t]) * rest);
      }
      return;
    }
    const Patch& patch = patches_[edges.patch];
    std::vector<double> at_vertices(patch.vertices.size() * components * kLanes);
    const TurnJob job{&fields_.vertices(),
                      &fields_.own_rows(),
                      fields_.own_row().data(),
                      values[first / kLanes].data(),
                      components,
                      quaternions,
                      remainders,
                      edges_.data(),
                      patch.vertices.data(),
                      patch.corners.data(),
                      SizeOf(patch.vertices),
                      edges.listed.data(),
                      SizeOf(edges.listed),
                      at_vertices.data(),
                      edges.Face(0)};
    HasFused() ? fused::TurnEdges(job) : plain::TurnEdges(job);
  };
  const RowTargets origin = RowTargets::Zero(std::ssize(system_.rows()), 3);
  std::vector<Eigen::Matrix3d> bodies;
  for (const FrameFields& frame : frames) bodies.push_back(frame.body);
  system_.SolveInto(SizeOf(frames), fill, std::vector<RowTargets>(frames.size(), origin), bodies,
                    space.rows, space.poses);
}

Eigen::Matrix3d FrameSolver::RotationAt(int vertex, const FrameFields& frame) const {
  FrameFields turns = frame;
  turns.log_stretches.resize(0, 6);
  Row row;
  const WeightedRow weights = RowAt(fields_.vertices(), vertex);
  for (int k = 0; k < weights.count; ++k) row.emplace_back(weights.mark[k], weights.weight[k]);
  return frame.body * MapAt(row, turns);
}

}  // namespace keypose::motion
