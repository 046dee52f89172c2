#include "motion/tracking/calm_take.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"
#include "motion/tracking/pose_band.h"

namespace keypose::motion {
namespace {

static_assert(PoseBand::kReach == kJerk);

constexpr int kCalmRounds = 12;
constexpr double kLargestStep = 2e-4;  // [m] or [rad] of the largest step: below what is seen

/// The numbers from one pose to another; the root's turn in the world.
DofVector StepBetween(const BodyPose& from, const BodyPose& to) {
  DofVector step = to.q - from.q;
  step.segment<3>(3) = LogOf((to.RootRotation() * from.RootRotation().conjugate()).normalized());
  return step;
}

BodyPose Moved(const BodyPose& pose, const DofVector& step) {
  BodyPose moved = pose;
  moved.q += step;
  return moved.Recharted();
}

DofVector Holds() {
  DofVector weights = DofVector::Constant(1 / (CalmTuning::kHoldTurn * CalmTuning::kHoldTurn));
  weights.head<3>().setConstant(1 / (CalmTuning::kHoldMove * CalmTuning::kHoldMove));
  return weights;
}

/// Each number's course over the take; that of the root's turn is the sum of its steps.
std::array<Course, kDofs> CoursesOf(const std::vector<FittedFrame>& frames) {
  std::vector<DofVector> values(frames.size()), variances(frames.size());
  values[0].setZero();
  for (std::size_t f = 1; f < frames.size(); ++f)
    values[f] = values[f - 1] + StepBetween(frames[f - 1].pose, frames[f].pose);
  ParallelFor(SizeOf(frames), [&](std::int64_t f) {
    DofMatrix matrix = frames[f].evidence.matrix;
    matrix.diagonal() += Holds();
    variances[f] = matrix.ldlt().solve(DofMatrix::Identity()).diagonal();
  });
  std::array<Course, kDofs> courses;
  for (int i = 0; i < kDofs; ++i)
    for (std::size_t f = 0; f < frames.size(); ++f) {
      courses[i].values.push_back(values[f][i]);
      courses[i].variances.push_back(variances[f][i]);
    }
  return courses;
}

struct Statistics {
  DofVector jerks;   ///< variances
  double noise = 1;  ///< factor on variances
};

/// Of all numbers; the noise is the median's, since what no outline tells shows none.
Statistics FindStatistics(const std::vector<FittedFrame>& frames) {
  const std::array<Course, kDofs> courses = CoursesOf(frames);
  std::array<MotionNoise, kDofs> each;
  ParallelFor(kDofs, [&](std::int64_t i) { each[i] = FindMotionNoise(courses[i]); });
  Statistics all;
  std::array<double, kDofs> noises;
  for (int i = 0; i < kDofs; ++i) {
    all.jerks[i] = each[i].jerk;
    noises[i] = each[i].noise;
  }
  all.noise = UpperMedian(noises);
  return all;
}

/// Adds the jerks of the frames from `f` on.
void AddJerks(const std::vector<BodyPose>& poses, int f, const DofVector& variances, PoseBand* band,
              std::vector<DofVector>* gradient) {
  const DofVector jerk = StepBetween(poses[f + 2], poses[f + 3]) -
                         2 * StepBetween(poses[f + 1], poses[f + 2]) +
                         StepBetween(poses[f], poses[f + 1]);
  DofVector weight;
  for (int i = 0; i < kDofs; ++i)
    weight[i] = JerkWeight(jerk[i] * jerk[i], variances[i]) / variances[i];
  for (int i = 0; i <= kJerk; ++i) {
    (*gradient)[f + i] += kJerkWeights[i] * weight.cwiseProduct(jerk);
    for (int j = i; j <= kJerk; ++j)
      band->Block(f + i, j - i).diagonal() += kJerkWeights[i] * kJerkWeights[j] * weight;
  }
}

/// One Gauss-Newton step for all frames.
std::vector<DofVector> StepOfAll(const std::vector<FittedFrame>& frames,
                                 const std::vector<BodyPose>& poses, const Statistics& statistics) {
  PoseBand band(SizeOf(frames));
  std::vector<DofVector> gradient(frames.size());
  for (int f = 0; f < SizeOf(frames); ++f) {
    DofMatrix& own = band.Block(f, 0);
    own = frames[f].evidence.matrix;
    own.diagonal() += Holds();
    own /= statistics.noise;
    gradient[f] = frames[f].evidence.gradient / statistics.noise;
    gradient[f].noalias() += own * StepBetween(frames[f].pose, poses[f]);
  }
  for (int f = 0; f + kJerk < SizeOf(frames); ++f)
    AddJerks(poses, f, statistics.jerks, &band, &gradient);
  for (DofVector& g : gradient) g = -g;
  return band.Solve(std::move(gradient));
}

}  // namespace

CalmedTake CalmTake(const std::vector<FittedFrame>& frames, double strength) {
  CalmedTake take;
  for (const FittedFrame& frame : frames) take.poses.push_back(frame.pose);
  if (SizeOf(frames) < kLeastFrames) return take;
  Statistics statistics = FindStatistics(frames);
  take.noise = std::sqrt(statistics.noise);
  take.jerks = statistics.jerks;
  statistics.noise *= strength * strength;
  double largest = 1;
  for (take.rounds = 0; take.rounds < kCalmRounds && largest > kLargestStep; ++take.rounds) {
    const std::vector<DofVector> steps = StepOfAll(frames, take.poses, statistics);
    largest = 0;
    for (int f = 0; f < SizeOf(frames); ++f) {
      take.poses[f] = Moved(take.poses[f], steps[f]);
      largest = std::max(largest, steps[f].cwiseAbs().maxCoeff());
    }
  }
  return take;
}

}  // namespace keypose::motion
