#include "motion/tracking/camera_turns.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kTurnRounds = 10;        // each takes in half of what is left, or more
constexpr double kUsualTurn = 0.0175;  // [rad] a degree; a camera that was bumped
constexpr double kUsualMiss_px = 2;    // of outlines, by masks and template

/// The outlines' pull at one camera's turn.
struct TurnSystem {
  Matrix3d matrix = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  double cost = 0, measured = 0;
};

TurnSystem SystemOf(const Silhouette& silhouette, const LocalSurface& surface,
                    const PosedBody& body) {
  TurnSystem system;
  constexpr double kReach = OutlineTuning::kReach;
  const ViewMatches matches = FindMatches(silhouette, surface, body, kReach);
  VisitResiduals(silhouette, matches, body, [&](const OutlineResidual& r) {
    // A turn w of the camera moves the point by -w x (X - c) before it.
    const Vector3d from_camera = r.x - silhouette.center, slope = r.pull.cross(from_camera);
    const double weight = r.stands_for * TukeyWeight(r.value, kReach);
    system.matrix += weight * slope * slope.transpose();
    system.right -= weight * r.value * slope;
    system.cost += r.stands_for * TukeyLoss(r.value, kReach);
    system.measured += r.stands_for;
  });
  return system;
}

/// Per camera, summed over frames in their order.
std::vector<TurnSystem> Systems(const std::vector<TurnFrame>& frames, const BodyShape& shape) {
  const LocalSurface surface = SurfaceOf(shape);
  const std::size_t cameras = frames[0].silhouettes.size();
  std::vector<std::vector<TurnSystem>> each(frames.size());
  ParallelFor(SizeOf(frames), [&](std::int64_t f) {
    const PosedBody body = Posed(frames[f].pose, shape);
    for (const Silhouette& silhouette : frames[f].silhouettes)
      each[f].push_back(SystemOf(silhouette, surface, body));
  });
  std::vector<TurnSystem> sums(cameras);
  for (const std::vector<TurnSystem>& frame : each)
    for (std::size_t c = 0; c < cameras; ++c) {
      sums[c].matrix += frame[c].matrix;
      sums[c].right += frame[c].right;
      sums[c].cost += frame[c].cost;
      sums[c].measured += frame[c].measured;
    }
  return sums;
}

double CostOf(const std::vector<TurnSystem>& systems) {
  double cost = 0, measured = 0;
  for (const TurnSystem& s : systems) {
    cost += s.cost;
    measured += s.measured;
  }
  return measured > 0 ? cost / measured : 0;
}

void FollowPoses(const BodyShape& shape, std::vector<TurnFrame>* frames) {
  const LocalSurface surface = SurfaceOf(shape);
  PoseOptions options;
  options.rounds = 2;
  options.priors = {RestPrior()};
  ParallelFor(SizeOf(*frames), [&](std::int64_t f) {
    TurnFrame& frame = (*frames)[f];
    frame.pose = SolvePose(frame.silhouettes, shape, surface, frame.pose, options).pose.Recharted();
  });
}

/// A move of the body looks like small turns of all cameras. Of the turns that differ by one, those
/// with the fewest cameras turned: a tripod is bumped, not all of them.
void TakeOutMove(const std::vector<Vector3d>& centers, const Vector3d& body,
                 std::vector<Vector3d>* turns) {
  constexpr int kRounds = 30;
  constexpr double kLeast = 1e-4;  // [rad]
  Vector3d move = Vector3d::Zero();
  const auto effect = [&](std::size_t c) {
    const Vector3d way = body - centers[c];
    Matrix3d cross;
    cross << 0, -way.z(), way.y(), way.z(), 0, -way.x(), -way.y(), way.x(), 0;
    return Matrix3d(cross / way.squaredNorm());
  };
  for (int round = 0; round < kRounds; ++round) {
    Matrix3d matrix = 1e-9 * Matrix3d::Identity();
    Vector3d right = Vector3d::Zero();
    for (std::size_t c = 0; c < turns->size(); ++c) {
      const Matrix3d e = effect(c);
      const double weight = 1 / std::max(kLeast, ((*turns)[c] - e * move).norm());
      matrix += weight * e.transpose() * e;
      right += weight * e.transpose() * (*turns)[c];
    }
    move = matrix.ldlt().solve(right);
  }
  for (std::size_t c = 0; c < turns->size(); ++c) (*turns)[c] -= effect(c) * move;
}

Vector3d MiddleOf(const std::vector<TurnFrame>& frames) {
  Vector3d sum = Vector3d::Zero();
  for (const TurnFrame& frame : frames) sum += frame.pose.q.head<3>();
  return sum / SizeOf(frames);
}

}  // namespace

Rigid3 TurnedBy(const Rigid3& camera_from_world, const Vector3d& turn) {
  const Vector3d center = camera_from_world.Inverse().translation;
  const Eigen::Quaterniond rotation =
      (camera_from_world.rotation * QuaternionOf(turn).conjugate()).normalized();
  return {rotation, -(rotation * center)};
}

CameraTurns FindCameraTurns(std::vector<TurnFrame> frames, const BodyShape& shape) {
  const std::size_t cameras = frames[0].silhouettes.size();
  CameraTurns found;
  found.turns.assign(cameras, Vector3d::Zero());
  found.shift_px.assign(cameras, 0);
  FollowPoses(shape, &frames);
  std::vector<TurnSystem> systems = Systems(frames, shape);
  for (const TurnSystem& s : systems)
    if (s.measured == 0) return found;
  found.before = CostOf(systems);
  std::vector<Rigid3> start;
  for (const Silhouette& s : frames[0].silhouettes) start.push_back(s.camera_from_world);
  constexpr double kHold = kUsualMiss_px * kUsualMiss_px / (kUsualTurn * kUsualTurn);
  std::vector<Vector3d> centers;
  for (const Rigid3& camera : start) centers.push_back(camera.Inverse().translation);
  for (int round = 0; round < kTurnRounds; ++round) {
    for (std::size_t c = 0; c < cameras; ++c) {
      const Matrix3d matrix = systems[c].matrix + kHold * Matrix3d::Identity();
      const Vector3d right = systems[c].right - kHold * found.turns[c];
      found.turns[c] += matrix.ldlt().solve(right);  // small turns add up
    }
    TakeOutMove(centers, MiddleOf(frames), &found.turns);
    for (std::size_t c = 0; c < cameras; ++c)
      for (TurnFrame& frame : frames)
        frame.silhouettes[c].camera_from_world = TurnedBy(start[c], found.turns[c]);
    FollowPoses(shape, &frames);
    systems = Systems(frames, shape);
  }
  found.after = CostOf(systems);
  for (std::size_t c = 0; c < cameras; ++c) {
    const Vector3d axis = start[c].rotation.conjugate() * Vector3d::UnitZ();
    const Vector3d across = found.turns[c] - axis.dot(found.turns[c]) * axis;
    found.shift_px[c] = across.norm() * frames[0].silhouettes[c].pinhole.fx;
  }
  return found;
}

}  // namespace keypose::motion
