#include "motion/root/placed_poses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "deform/solvers/dense_product.h"

namespace keypose::motion {

namespace {

/// With more marks than this their turns alone tell the places well enough.
constexpr int kMostChained = 300;
constexpr double kRidge = 1e-5;  // keeps marks that nearly coincide from pulling each other apart

/// Values of vertices, smoothed over the system's screening length. Rows that sum to 1 still do.
Eigen::MatrixXd Smoothed(const PoissonSystem& system, Eigen::MatrixXd values) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(values.rows());
  for (Eigen::Index f = 0; f < system.faces().rows(); ++f)
    for (int k = 0; k < 3; ++k) mass[system.faces()(f, k)] += system.face_areas()[f];
  values = mass.asDiagonal() * values;
  values = system.SolveScreened(values);
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    if (const double sum = values.row(i).sum(); sum > 0) values.row(i) /= sum;
  return values;
}

/// What a unit move of each mark does to each vertex.
Eigen::MatrixXd CarriedBy(const PoissonSystem& system, const MarkFields& fields,
                          const std::vector<MarkPlace>& places) {
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(system.vertex_count(), fields.marks());
  const WeightRows& rows = fields.vertices();
  for (int i = 0; i < rows.rows(); ++i)
    for (int k = rows.begin[i]; k < rows.begin[i + 1]; ++k)
      weights(i, rows.mark[k]) = rows.weight[k];
  const Eigen::MatrixXd smooth = Smoothed(system, weights);
  Eigen::MatrixXd at_marks = Eigen::MatrixXd::Zero(fields.marks(), fields.marks());
  for (int k = 0; k < SizeOf(places); ++k)
    for (int c = 0; c < 3; ++c)
      at_marks.row(k) += places[k].barycentric[c] * smooth.row(system.faces()(places[k].face, c));
  const Eigen::MatrixXd normal = at_marks.transpose() * at_marks +
                                 kRidge * Eigen::MatrixXd::Identity(fields.marks(), fields.marks());
  return smooth * normal.ldlt().solve(at_marks.transpose());
}

}  // namespace

PlacedPoses::PlacedPoses(const PointsX3& rest, const FacesX3& faces, std::vector<MarkPlace> places,
                         const MarkFields& fields, const RootPath& path, PoissonSystem system,
                         bool screened)
    : faces_(faces),
      places_(std::move(places)),
      path_(path),
      solver_(rest, faces, fields, std::move(system)),
      joined_(solver_.system(), rest, faces(places_[path.central_mark()].face, 0)) {
  if (screened && fields.marks() <= kMostChained)
    carried_ = CarriedBy(solver_.system(), fields, places_);
}

PointsX3 PlacedPoses::MarksOf(const PointsX3& pose) const {
  PointsX3 marks(std::ssize(places_), 3);
  for (int k = 0; k < SizeOf(places_); ++k) marks.row(k) = PositionOf(places_[k], pose, faces_);
  return marks;
}

void PlacedPoses::Place(std::span<const MotionFrame> frames, std::span<PointsX3> poses) const {
  const int count = SizeOf(poses);
  Eigen::RowVectorXd shifts(3 * count);
  Eigen::MatrixXd gaps = Eigen::MatrixXd::Zero(std::ssize(places_), 3 * count);
  for (int t = 0; t < count; ++t) {
    PointsX3 marks = MarksOf(poses[t]);
    shifts.segment<3>(3 * t) = frames[t].root - path_.RootOf(marks);
    if (carried_.size() == 0 || frames[t].marks.size() == 0) continue;
    marks.rowwise() += shifts.segment<3>(3 * t);
    PointsX3 wanted = frames[t].marks;
    wanted.rowwise() += frames[t].root - path_.RootOf(wanted);
    gaps.middleCols<3>(3 * t) = wanted - marks;
  }
  constexpr int kRows = 512;  // whose moves stay in the second cache
  ParallelBlocks(poses[0].rows(), kRows, [&](std::int64_t begin, std::int64_t end) {
    Eigen::MatrixXd moves = shifts.replicate(end - begin, 1);
    if (carried_.size() > 0)
      Multiply(1.0, carried_.middleRows(begin, end - begin), gaps, Flip::kNone, 1.0, moves);
    for (int t = 0; t < count; ++t)
      poses[t].middleRows(begin, end - begin) += moves.middleCols<3>(3 * t);
  });
}

std::vector<PointsX3> PlacedPoses::Make(std::span<const MotionFrame> frames) const {
  FrameSolver::Space space;
  Make(frames, space);
  return std::move(space.poses);
}

PointsX3 PlacedPoses::MakeOne(const MotionFrame& frame) const {
  PointsX3 pose = solver_.SolveOne(frame.fields);
  joined_.Join(solver_, frame.fields, pose);
  Place({&frame, 1}, {&pose, 1});
  return pose;
}

void PlacedPoses::Make(std::span<const MotionFrame> frames, FrameSolver::Space& space) const {
  std::vector<FrameFields> fields;
  for (const MotionFrame& frame : frames) fields.push_back(frame.fields);
  solver_.Solve(fields, space);
  std::vector<PointsX3>& poses = space.poses;
  ParallelFor(std::ssize(poses),
              [&](std::int64_t t) { joined_.Join(solver_, frames[t].fields, poses[t]); });
  Place(frames, poses);
}

}  // namespace keypose::motion
