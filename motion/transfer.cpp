#include "motion/transfer.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <span>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "motion/fields/rest_turns.h"
#include "motion/reconstruct/kept_volume.h"
#include "motion/reconstruct/literal_transfer.h"
#include "motion/root/mark_chain.h"
#include "motion/root/placed_poses.h"
#include "motion/root/root_path.h"
#include "motion/root/settled_pose.h"

namespace keypose::motion {

namespace {

constexpr double kOpposite = 90 * kDegree;  // poses further apart do not resemble each other
/// Numbers in a batch of frames: what bounds the memory on large meshes.
constexpr std::int64_t kBatchNumbers = 12'000'000;
constexpr int kMostTogether = 24;

std::vector<int> TargetFaces(const std::vector<Mark>& marks) {
  std::vector<int> faces;
  for (const Mark& mark : marks) faces.push_back(mark.on_target.face);
  return faces;
}

std::vector<MarkPlace> TargetPlaces(const std::vector<Mark>& marks) {
  std::vector<MarkPlace> places;
  for (const Mark& mark : marks) places.push_back(mark.on_target);
  return places;
}

MarkFieldOptions FieldOptions(TransferMethod method) {
  MarkFieldOptions options;
  if (method == TransferMethod::kAuto) options.least_weight = 1e-4;
  options.bounded = method == TransferMethod::kAuto;
  return options;
}

Eigen::Matrix<double, 6, 1> SymmetricNumbers(const Eigen::Matrix3d& m) {
  Eigen::Matrix<double, 6, 1> numbers;
  numbers << m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2);
  return numbers;
}

}  // namespace

struct Transfer::Impl {
  Impl(const Mesh& target_mesh, const PointsX3& reference, const FacesX3& template_faces,
       const std::vector<Mark>& given, const TransferOptions& o);

  std::future<PoissonSystem> SystemBeside() const;
  void Align();
  void KeepPose(const MarkPose& pose);
  Eigen::MatrixXd Stretches(const MarkPose& pose) const;
  void Plan();
  std::vector<PointsX3> LiteralPoses(int first, int count) const;
  PointsX3 PoseOf(int frame) const;
  bool Finish(int frame, PointsX3& pose, PoseSettler::Space& space, TransferReport& made) const;

  const PointsX3 target, template_reference;
  const FacesX3 faces, template_faces;
  const std::vector<Mark> marks;
  const TransferOptions options;
  std::future<PoissonSystem> system;  // none for the literal method
  MarkMeter meter;
  MarkTree tree;
  MarkFields fields;
  std::unique_ptr<PlacedPoses> placed;  // none for the literal method
  std::unique_ptr<LiteralTransfer> literal;
  std::unique_ptr<KeptVolume> kept;
  std::unique_ptr<TurnFollower> follower;
  std::unique_ptr<RootPath> path;
  std::unique_ptr<MarkChain> chain;
  std::vector<Eigen::Quaterniond> rest_turns;  // of the marks
  std::unique_ptr<Holds> holds;
  bool planned = false;
  Eigen::Matrix3d target_from_template = Eigen::Matrix3d::Identity();
  double diagonal = 1;

  std::vector<MotionFrame> frames;
  std::vector<std::vector<Eigen::Quaterniond>> quaternions;  // for the literal method
  PoseSettler::Space settling;                               // of single frames
  TransferReport report;
};

Transfer::Impl::Impl(const Mesh& target_mesh, const PointsX3& reference, const FacesX3& tf,
                     const std::vector<Mark>& given, const TransferOptions& o)
    : target((RequireUsable(target_mesh, "transfer: the target"), target_mesh.points)),
      template_reference(reference),
      faces(target_mesh.faces),
      template_faces(tf),
      marks((RequireMarks(given, reference, tf, target_mesh), given)),
      options(o),
      system(SystemBeside()),
      meter(marks, template_reference, template_faces),
      tree(JoinMarks(target, faces, TargetPlaces(marks))),
      fields(target, faces, TargetFaces(marks), FieldOptions(o.method)),
      diagonal(BoundingDiagonal(target)) {
  Align();
  const bool automatic = options.method == TransferMethod::kAuto;
  const bool holding = automatic && (options.feet || !options.pins.empty());
  if (holding)
    holds = std::make_unique<Holds>(
        target, faces, marks, template_reference, template_faces,
        [this](const Eigen::RowVector3d& point) { return path->OnTarget(point); }, options.pins,
        options.feet);
  if (options.method == TransferMethod::kLiteral) {
    literal = std::make_unique<LiteralTransfer>(target, faces, TargetFaces(marks));
  } else {
    placed = std::make_unique<PlacedPoses>(target, faces, TargetPlaces(marks), fields, *path,
                                           system.get(), automatic);
    if (automatic && options.volume)
      kept = std::make_unique<KeptVolume>(placed->solver().system(), target);
  }
  follower = std::make_unique<TurnFollower>(tree, options.follow);
  report.least_weight = fields.least_weight();
  report.unmarked_parts = fields.unmarked_parts();
}

/// Factored beside the marks' fields, as each of both takes one core.
std::future<PoissonSystem> Transfer::Impl::SystemBeside() const {
  if (options.method == TransferMethod::kLiteral) return {};
  const auto when = ThreadCount() > 1 ? std::launch::async : std::launch::deferred;
  return std::async(when, [this] {
    return FrameSolver::SystemOf(target, faces, options.method == TransferMethod::kAuto);
  });
}

void Transfer::Impl::Align() {
  PointsX3 on_template(std::ssize(marks), 3), on_target(std::ssize(marks), 3);
  for (int k = 0; k < SizeOf(marks); ++k) {
    on_template.row(k) = PositionOf(marks[k].on_template, template_reference, template_faces);
    on_target.row(k) = PositionOf(marks[k].on_target, target, faces);
  }
  report.alignment = AlignMarks(on_template, on_target);
  target_from_template = DirectionsOf(report.alignment);
  report.turned = !target_from_template.isIdentity();
  if (!options.align && report.turned) {
    const double angle = Eigen::AngleAxisd(target_from_template).angle();
    if (angle > kOpposite)
      throw InputError(
          "transfer: template and target face opposite ways: the marks of the target "
          "are turned by " +
          std::to_string(std::lround(angle / kDegree)) +
          " degrees; turn one of the meshes, or leave align on");
    target_from_template.setIdentity();
    report.turned = false;
  }
  const bool automatic = options.method == TransferMethod::kAuto;
  std::vector<int> root = tree.central;
  if (automatic) root.resize(BodyMarks(SizeOf(marks)));
  RootPathOptions root_options;
  root_options.scale = automatic ? 0 : 1;
  if (options.scale > 0) root_options.scale = options.scale;
  path = std::make_unique<RootPath>(on_template, on_target, template_reference.col(2).minCoeff(),
                                    target.col(2).minCoeff(), std::move(root),
                                    report.alignment.scale, target_from_template, root_options);
  report.path_scale = path->scale();
  rest_turns.assign(marks.size(), Eigen::Quaterniond::Identity());
  if (automatic && options.rest)
    rest_turns = RestTurns(tree, on_template * target_from_template.transpose(), on_target);
  for (const Eigen::Quaterniond& turn_at_rest : rest_turns)
    report.largest_rest_turn = std::max(report.largest_rest_turn, LogOf(turn_at_rest).norm());
  if (automatic)
    chain = std::make_unique<MarkChain>(tree, on_template, on_target, target_from_template);
}

void Transfer::Impl::KeepPose(const MarkPose& pose) {
  const Eigen::Quaterniond turn(target_from_template);
  std::vector<Eigen::Quaterniond> rotations;
  for (int k = 0; k < SizeOf(marks); ++k)
    rotations.push_back(turn * pose.maps[k].rotation * turn.conjugate() * rest_turns[k]);
  MotionFrame frame;
  frame.root = path->At(pose.positions);
  if (options.method == TransferMethod::kAuto) {
    const MarkTurns turns = follower->Next(rotations);
    report.largest_turn_between = follower->largest_between();
    frame.fields = FrameFields::Turns(turns);
    frame.marks = chain->At(pose.positions, turns, rest_turns);
    if (options.stretch > 0) frame.fields.log_stretches = Stretches(pose);
  } else {
    quaternions.push_back(WithAgreeingSigns(tree, rotations));
    frame.fields = FrameFields::Quaternions(quaternions.back());
  }
  frames.push_back(std::move(frame));
}

/// M x 6, the share of the template's stretches that is wanted, in the target's directions.
Eigen::MatrixXd Transfer::Impl::Stretches(const MarkPose& pose) const {
  Eigen::MatrixXd logs(std::ssize(marks), 6);
  for (int k = 0; k < SizeOf(marks); ++k)
    logs.row(k) =
        options.stretch * SymmetricNumbers(target_from_template * pose.maps[k].log_stretch *
                                           target_from_template.transpose());
  return logs;
}

/// Poses in their places.
std::vector<PointsX3> Transfer::Impl::LiteralPoses(int first, int count) const {
  std::vector<PointsX3> poses;
  for (int t = first; t < first + count; ++t) {
    poses.push_back(literal->Pose(quaternions[t]));
    PointsX3 at(std::ssize(marks), 3);
    for (int k = 0; k < SizeOf(marks); ++k)
      at.row(k) = PositionOf(marks[k].on_target, poses.back(), faces);
    poses.back().rowwise() += frames[t].root - path->RootOf(at);
  }
  return poses;
}

/// One frame in its place, without volume and holds.
PointsX3 Transfer::Impl::PoseOf(int frame) const {
  return placed ? placed->MakeOne(frames[frame]) : LiteralPoses(frame, 1).front();
}

void Transfer::Impl::Plan() {
  if (planned) return;
  planned = true;
  if (holds) holds->Plan(placed->solver().system(), *path, options.fps, frames);
}

/// Volume and holds.
/// @return whether the pose is finite
bool Transfer::Impl::Finish(int frame, PointsX3& pose, PoseSettler::Space& space,
                            TransferReport& made) const {
  const PoseSettler settler(kept.get(), holds ? holds->patches() : nullptr);
  PoseSettler::Report settled;
  const auto goals_of = [&](const PointOf& point_of) {
    return holds ? holds->GoalsOf(frame, point_of) : std::vector<HeldPatches::Goal>{};
  };
  settler.Settle(goals_of, pose, space, settled);
  made.volume_before = settled.deviation;
  made.volume_move_over_diag = settled.volume_move / diagonal;
  made.holds.held_move = settled.held_move;
  return (pose.array() * 0).sum() == 0;
}

Transfer::Transfer(const Mesh& target, const PointsX3& reference, const FacesX3& template_faces,
                   const std::vector<Mark>& marks, const TransferOptions& options)
    : impl_(std::make_unique<Impl>(target, reference, template_faces, marks, options)) {}
Transfer::~Transfer() = default;

void Transfer::Add(const PointsX3& frame, const std::string& name) {
  impl_->KeepPose(impl_->meter.Measure(frame, name));
  if (impl_->holds) impl_->holds->Watch(frame);
}

int Transfer::frame_count() const { return SizeOf(impl_->frames); }

void Transfer::Run(const std::function<void(int, const PointsX3&)>& take, Progress* progress) {
  Impl& s = *impl_;
  s.Plan();
  const int together = static_cast<int>(std::clamp<std::int64_t>(
      kBatchNumbers / std::max<std::int64_t>(1, 3 * s.target.rows()) / 4 * 4, 4, kMostTogether));
  if (s.holds) s.report.holds = s.holds->report();
  FrameSolver::Space space;
  std::vector<PoseSettler::Space> settling(ThreadCount());
  for (int first = 0; first < frame_count(); first += together) {
    ReportProgress(progress, static_cast<double>(first) / frame_count(), "transferring");
    const int count = std::min(together, frame_count() - first);
    if (s.placed)
      s.placed->Make(std::span(s.frames).subspan(first, count), space);
    else
      space.poses = s.LiteralPoses(first, count);
    std::vector<PointsX3>& poses = space.poses;
    std::vector<TransferReport> made(count);
    std::vector<char> finite(count);
    // A few blocks of frames, each with its own memory.
    const std::int64_t grain = (count + std::ssize(settling) - 1) / std::ssize(settling);
    ParallelBlocks(count, grain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t k = begin; k < end; ++k)
        finite[k] =
            s.Finish(first + static_cast<int>(k), poses[k], settling[begin / grain], made[k]);
    });
    for (int k = 0; k < count; ++k) {
      s.report.TakeWorst(made[k]);
      if (!finite[k])
        throw SolverError("transfer: frame " + std::to_string(first + k) +
                          " is not finite; check the target with keypose cleanup");
      take(first + k, poses[k]);
    }
  }
}

PointsX3 Transfer::Frame(int frame) {
  impl_->Plan();
  PointsX3 pose = impl_->PoseOf(frame);
  TransferReport made;
  impl_->Finish(frame, pose, impl_->settling, made);
  return pose;
}

void TransferReport::TakeWorst(const TransferReport& frame) {
  volume_before = std::max(volume_before, frame.volume_before);
  volume_move_over_diag = std::max(volume_move_over_diag, frame.volume_move_over_diag);
  holds.held_move = std::max(holds.held_move, frame.holds.held_move);
}

const TransferReport& Transfer::report() const { return impl_->report; }

PointsX3 Transfer::InTemplateSpace(const PointsX3& points) const {
  return impl_->path->OnTemplate(points);
}

}  // namespace keypose::motion
