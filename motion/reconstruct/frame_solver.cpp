#include "motion/reconstruct/frame_solver.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/values/size_of.h"
#include "deform/solvers/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::motion {

namespace {

constexpr int kLanes = 4;
constexpr int kMostGroups = 3;  // of four frames whose fields are mixed together

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

/// What the marks' values are.
enum class TurnKind { kQuaternion, kVector, kTwoVectors };
inline int ComponentsOf(TurnKind kind) {
  if (kind == TurnKind::kQuaternion) return 4;
  return kind == TurnKind::kVector ? 3 : 6;
}

/// Rows of places: of the vertices, then of marked faces.
struct PlaceRows {
  const WeightRows *vertices, *own;
};
inline WeightedRow RowAt(const PlaceRows& rows, int place) {
  const int own = place - rows.vertices->rows();
  return own < 0 ? RowAt(*rows.vertices, place) : RowAt(*rows.own, own);
}

/// Some groups of four frames of the turns of a patch.
struct MixJob {
  PlaceRows rows;
  TurnKind kind;
  int groups;
  const double* values;  // of the marks: [mark][component][frame]
  const int* places;     // of the patch
  int place_count;
  double* fields;  // room for [place][component][frame]
  double* turns;   // [group][place][component][frame of the group]
};

/// Four frames of the edges of a patch.
struct TurnJob {
  const double *edges, *turns;  // turns: of the group
  const int* corners;           // of its faces, among the places
  const int* listed;
  int count;
  double* out;
};

/// One frame of the turns of all places.
struct OneMixJob {
  PlaceRows rows;
  TurnKind kind;
  const double* values;  // of the marks: [mark][component], components of the turn 0 .. 3, of the
                         // remainder 4 .. 7
  double* turns;         // [place][component]
};

/// One frame of the edges of some faces.
struct OneTurnJob {
  const double *edges, *turns;
  const int* corners;  // of all faces
  const int* listed;
  int count;
  double* out;  // eight numbers a face
};

}  // namespace

namespace plain {
using namespace keypose::plain;
#include "motion/reconstruct/inverse_root.inc"
#include "motion/reconstruct/turned_edges.inc"
}  // namespace plain
KEYPOSE_FUSED_BEGIN
namespace fused {
using namespace keypose::fused;
#include "motion/reconstruct/inverse_root.inc"
#include "motion/reconstruct/turned_edges.inc"
}  // namespace fused
KEYPOSE_FUSED_END

namespace {

Eigen::Matrix3d SymmetricOf(const Eigen::Matrix<double, 6, 1>& s) {
  Eigen::Matrix3d m;
  m << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  return m;
}

Eigen::Matrix3d ExpOfSymmetric(const Eigen::Matrix3d& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
  return solver.eigenvectors() * solver.eigenvalues().array().exp().matrix().asDiagonal() *
         solver.eigenvectors().transpose();
}

/// The weighted sum of the marks' rows.
template <int Count>
Eigen::Matrix<double, Count, 1> MixedRow(const WeightedRow& row, const auto& values) {
  Eigen::Matrix<double, Count, 1> sum = Eigen::Matrix<double, Count, 1>::Zero();
  for (int k = 0; k < row.count; ++k) sum += row.weight[k] * values.row(row.mark[k]).transpose();
  return sum;
}

/// The turn that the fields ask at a place, without the body. Places nearby have quaternions
/// nearby.
Eigen::Vector4d TurnAt(const WeightedRow& row, const FrameFields& frame) {
  if (frame.quaternions.size() > 0) return MixedRow<4>(row, frame.quaternions);
  Eigen::Quaterniond turn = QuaternionOf(MixedRow<3>(row, frame.turns));
  if (frame.remainders.size() > 0) turn = turn * QuaternionOf(MixedRow<3>(row, frame.remainders));
  return {turn.w(), turn.x(), turn.y(), turn.z()};
}

Eigen::Matrix3d RotationOf(const Eigen::Vector4d& turn) {
  const Eigen::Vector4d q = turn.norm() > 0 ? turn.normalized() : Eigen::Vector4d::Unit(0);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

/// The marks' values of some groups of four frames, [mark][component][frame]; the last frame
/// repeats at the end.
struct GroupValues {
  int groups = 0;
  std::vector<double> values;
};

/// Component of the turn, then of its remainder.
double VectorAt(const FrameFields& frame, Eigen::Index k, int c) {
  if (c < 3) return frame.turns(k, c);
  return frame.remainders.size() > 0 ? frame.remainders(k, c - 3) : 0.0;
}

GroupValues ValuesOf(const std::vector<FrameFields>& frames, int first, TurnKind kind) {
  const bool quaternions = kind == TurnKind::kQuaternion;
  const int components = ComponentsOf(kind),
            groups = std::min(kMostGroups, (SizeOf(frames) - first + kLanes - 1) / kLanes),
            count = groups * kLanes;
  const Eigen::Index marks =
      quaternions ? frames[first].quaternions.rows() : frames[first].turns.rows();
  GroupValues made{groups, std::vector<double>(marks * components * count, 0.0)};
  for (int lane = 0; lane < count; ++lane) {
    const FrameFields& frame = frames[std::min(first + lane, SizeOf(frames) - 1)];
    for (Eigen::Index k = 0; k < marks; ++k)
      for (int c = 0; c < components; ++c)
        made.values[(k * components + c) * count + lane] =
            quaternions ? frame.quaternions(k, c) : VectorAt(frame, k, c);
  }
  return made;
}

bool AnyOf(std::span<const FrameFields> frames, bool (*has)(const FrameFields&)) {
  return std::any_of(frames.begin(), frames.end(), has);
}

TurnKind KindOf(std::span<const FrameFields> frames) {
  if (frames[0].quaternions.size() > 0) return TurnKind::kQuaternion;
  const auto has = [](const FrameFields& frame) { return frame.remainders.size() > 0; };
  return AnyOf(frames, has) ? TurnKind::kTwoVectors : TurnKind::kVector;
}

bool AnyStretched(std::span<const FrameFields> frames) {
  return AnyOf(frames, [](const FrameFields& frame) { return frame.log_stretches.size() > 0; });
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
    : fields_(fields), system_(std::move(system)), corners_(faces) {
  edges_.reserve(6 * faces.rows() + 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k)
      for (int c = 0; c < 3; ++c) edges_.push_back(rest(faces(f, k), c) - rest(faces(f, 0), c));
  edges_.push_back(0);
  const int vertices = static_cast<int>(rest.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    if (const int own = fields.own_row()[f]; own >= 0) corners_.row(f).setConstant(vertices + own);
  CutPatches();
}

void FrameSolver::CutPatches() {
  std::vector<int> found(place_count(), -1);
  for (int p = 0; p < system_.patch_count(); ++p) {
    Patch patch;
    for (const int f : system_.FacesOfPatch(p))
      for (int k = 0; k < 3; ++k) {
        int& at = found[corners_(f, k)];
        if (at < 0) {
          at = SizeOf(patch.places);
          patch.places.push_back(corners_(f, k));
        }
        patch.corners.push_back(at);
      }
    for (const int i : patch.places) found[i] = -1;
    patches_.push_back(std::move(patch));
  }
}

int FrameSolver::place_count() const {
  return fields_.vertices().rows() + fields_.own_rows().rows();
}

std::vector<PointsX3> FrameSolver::Solve(const std::vector<FrameFields>& frames) const {
  Space space;
  Solve(frames, space);
  return std::move(space.poses);
}

/// Turns of all places in one frame, four numbers each.
std::vector<double> FrameSolver::TurnsOf(const FrameFields& frame) const {
  const TurnKind kind = KindOf({&frame, 1});
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values =
      Eigen::MatrixXd::Zero(fields_.marks(), kind == TurnKind::kTwoVectors ? 8 : 4);
  if (kind == TurnKind::kQuaternion)
    values = frame.quaternions;
  else
    values.leftCols<3>() = frame.turns;
  if (kind == TurnKind::kTwoVectors) values.middleCols<3>(4) = frame.remainders;
  std::vector<double> turns(4 * static_cast<std::size_t>(place_count()));
  const OneMixJob job{
      {&fields_.vertices(), &fields_.own_rows()}, kind, values.data(), turns.data()};
  constexpr int kPlacesTogether = 2048;
  ParallelBlocks(place_count(), kPlacesTogether, [&](std::int64_t begin, std::int64_t end) {
    const auto mix = HasFused() ? fused::MixTurnsOfOneFrame : plain::MixTurnsOfOneFrame;
    mix(job, static_cast<int>(begin), static_cast<int>(end));
  });
  return turns;
}

/// Calls take(k, edges) for each of the patch's faces.
void FrameSolver::StretchPatch(int patch, const FrameFields& frame, const TakeEdges& take) const {
  const PlaceRows rows{&fields_.vertices(), &fields_.own_rows()};
  const Patch& of = patches_[patch];
  std::vector<Eigen::Vector4d> turns;
  std::vector<Eigen::Matrix<double, 6, 1>> logs;
  for (const int place : of.places) {
    const WeightedRow row = RowAt(rows, place);
    turns.push_back(TurnAt(row, frame));
    logs.emplace_back(Eigen::Matrix<double, 6, 1>::Zero());
    if (frame.log_stretches.size() > 0) logs.back() = MixedRow<6>(row, frame.log_stretches);
  }
  const std::span<const int> listed = system_.FacesOfPatch(patch);
  for (int k = 0; k < SizeOf(listed); ++k) {
    const int a = of.corners[3 * k], b = of.corners[3 * k + 1], c = of.corners[3 * k + 2];
    const Eigen::Map<const Eigen::Matrix<double, 3, 2>> rest(edges_.data() + 6 * listed[k]);
    const Eigen::Matrix3d stretch = ExpOfSymmetric(SymmetricOf((logs[a] + logs[b] + logs[c]) / 3));
    take(k, RotationOf(turns[a] + turns[b] + turns[c]) * stretch * rest);
  }
}

PointsX3 FrameSolver::SolveOne(const FrameFields& frame) const {
  const bool stretched = AnyStretched({&frame, 1});
  const std::vector<double> turns = stretched ? std::vector<double>() : TurnsOf(frame);
  const auto fill = [&](int patch, double* edges) {
    if (stretched) {
      StretchPatch(patch, frame, [&](int k, const Eigen::Matrix<double, 3, 2>& made) {
        Eigen::Map<Eigen::Matrix<double, 4, 2>> out(edges + 8 * k);
        out << made, Eigen::RowVector2d::Zero();
      });
      return;
    }
    const std::span<const int> listed = system_.FacesOfPatch(patch);
    const OneTurnJob job{edges_.data(), turns.data(),   corners_.data(),
                         listed.data(), SizeOf(listed), edges};
    HasFused() ? fused::TurnEdgesOfOneFrame(job) : plain::TurnEdgesOfOneFrame(job);
  };
  return system_.SolveOne(fill, RowTargets::Zero(std::ssize(system_.rows()), 3), frame.body);
}

/// Turns at the places of a patch, kept from one group of frames to the next.
struct FrameSolver::PatchTurns {
  int first = -1;  // frame
  std::unique_ptr<double[]> turns;
};

void FrameSolver::Solve(const std::vector<FrameFields>& frames, Space& space) const {
  const TurnKind kind = KindOf(frames);
  const bool stretched = AnyStretched(frames);
  constexpr int kTogether = kMostGroups * kLanes;
  std::vector<GroupValues> values;
  for (int first = 0; first < SizeOf(frames); first += kTogether)
    values.push_back(ValuesOf(frames, first, kind));
  // One thread makes all frames of a patch, in order.
  std::vector<PatchTurns> mixed(patches_.size());
  const auto mix = [&](int patch, const GroupValues& of) {
    const std::vector<int>& places = patches_[patch].places;
    const std::size_t numbers = places.size() * of.groups * kLanes;
    const auto fields = std::make_unique_for_overwrite<double[]>(numbers * ComponentsOf(kind));
    auto turns = std::make_unique_for_overwrite<double[]>(numbers * 4);
    const MixJob job{{&fields_.vertices(), &fields_.own_rows()},
                     kind,
                     of.groups,
                     of.values.data(),
                     places.data(),
                     SizeOf(places),
                     fields.get(),
                     turns.get()};
    HasFused() ? fused::MixTurns(job) : plain::MixTurns(job);
    return turns;
  };
  const auto fill = [&](int first, EdgeBatch& edges) {
    for (int t = 0; stretched && t < edges.frames; ++t)
      StretchPatch(edges.patch, frames[first + t],
                   [&](int k, const auto& made) { edges.Set(k, t, made); });
    if (stretched) return;
    const Patch& patch = patches_[edges.patch];
    PatchTurns& made = mixed[edges.patch];
    const int start = first / kTogether * kTogether;
    if (made.first != start) made = {start, mix(edges.patch, values[first / kTogether])};
    const double* turns = made.turns.get() + (first - start) * 4 * patch.places.size();
    const TurnJob job{edges_.data(),        turns,        patch.corners.data(), edges.listed.data(),
                      SizeOf(edges.listed), edges.Face(0)};
    HasFused() ? fused::TurnEdges(job) : plain::TurnEdges(job);
    if (first + kLanes >= SizeOf(frames)) made = {};
  };
  const RowTargets origin = RowTargets::Zero(std::ssize(system_.rows()), 3);
  std::vector<Eigen::Matrix3d> bodies;
  for (const FrameFields& frame : frames) bodies.push_back(frame.body);
  system_.SolveInto(SizeOf(frames), fill, std::vector<RowTargets>(frames.size(), origin), bodies,
                    space.rows, space.poses);
}

Eigen::Matrix3d FrameSolver::RotationAt(int vertex, const FrameFields& frame) const {
  return frame.body * RotationOf(TurnAt(RowAt(fields_.vertices(), vertex), frame));
}

}  // namespace keypose::motion
