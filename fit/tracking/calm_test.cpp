#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/values/angles.h"
#include "fit/tracking/calm_take.h"
#include "fit/tracking/pose_band.h"

namespace keypose::fit::calm_test {

/// The place of the left elbow in a pose.
int Elbow() { return Joints()[kElbowL].first_dof; }

class Noise {
 public:
  explicit Noise(unsigned seed) : engine_(seed) {}
  double Draw() { return normal_(engine_); }
  DofVector Numbers() {
    DofVector numbers;
    for (double& x : numbers) x = Draw();
    return numbers;
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

/// A course whose acceleration changes by `jerk` a frame (standard deviation).
/// @param home  1: it is pulled back to zero slowly; 0: it goes where it goes
std::vector<double> Wandering(int frames, double jerk, double home, Noise* noise) {
  std::vector<double> course;
  double at = 0, speed = 0, acceleration = 0;
  for (int f = 0; f < frames; ++f) {
    course.push_back(at);
    acceleration += jerk * noise->Draw();
    acceleration -= home * (0.02 * at + 0.1 * speed + 0.2 * acceleration);
    speed += acceleration, at += speed;
  }
  return course;
}

/// Fits of true poses: correlated errors of an information matrix, the same for all frames.
std::vector<FittedFrame> Fitted(const std::vector<BodyPose>& truth, double deviation,
                                Noise* noise) {
  DofMatrix root = DofMatrix::Identity();  // information = root root^T / deviation^2
  for (int i = 1; i < kDofs; ++i) root(i, i - 1) = 0.5;
  std::vector<FittedFrame> frames;
  for (const BodyPose& pose : truth) {
    FittedFrame frame{pose, {}};
    frame.evidence.matrix = root * root.transpose() / (deviation * deviation);
    const DofVector error = deviation * root.transpose().inverse() * noise->Numbers();
    frame.pose.q += error;
    frame.pose = frame.pose.Recharted();
    frames.push_back(frame);
  }
  return frames;
}

std::vector<BodyPose> WanderingPoses(int frames, double jerk, Noise* noise) {
  std::vector<std::vector<double>> courses;
  for (int i = 0; i < kDofs; ++i) courses.push_back(Wandering(frames, jerk, 1, noise));
  std::vector<BodyPose> poses(static_cast<std::size_t>(frames));
  for (int f = 0; f < frames; ++f) {
    for (int i = 0; i < kDofs; ++i) poses[f].q[i] = courses[i][f];
    poses[f] = poses[f].Recharted();
  }
  return poses;
}

/// Root of the mean square of the joints' numbers, over the frames.
double ErrorOf(const std::vector<BodyPose>& poses, const std::vector<BodyPose>& truth) {
  double sum = 0;
  for (std::size_t f = 0; f < poses.size(); ++f)
    sum += (poses[f].q - truth[f].q).tail<kDofs - 6>().squaredNorm() / (kDofs - 6);
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

std::vector<BodyPose> PosesOf(const std::vector<FittedFrame>& frames) {
  std::vector<BodyPose> poses;
  for (const FittedFrame& frame : frames) poses.push_back(frame.pose);
  return poses;
}

TEST(PoseBand, SolvesAsADenseFactorDoes) {
  Noise noise(1);
  const int frames = 5, n = frames * kDofs;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  PoseBand band(frames);
  for (int f = 0; f < frames; ++f)
    for (int later = 0; later <= std::min(PoseBand::kReach, frames - 1 - f); ++later) {
      DofMatrix block;
      for (double& x : block.reshaped()) x = 0.1 * noise.Draw();
      if (later == 0) block = (block * block.transpose() + 5 * DofMatrix::Identity()).eval();
      band.Block(f, later) = block;
      dense.block<kDofs, kDofs>((f + later) * kDofs, f * kDofs) = block;
      dense.block<kDofs, kDofs>(f * kDofs, (f + later) * kDofs) = block.transpose();
    }
  std::vector<DofVector> right;
  Eigen::VectorXd all(n);
  for (int f = 0; f < frames; ++f)
    right.push_back(noise.Numbers()), all.segment<kDofs>(f * kDofs) = right[f];
  const Eigen::VectorXd expected = dense.llt().solve(all);
  const std::vector<DofVector> solved = band.Solve(right);
  for (int f = 0; f < frames; ++f)
    EXPECT_LT((solved[f] - expected.segment<kDofs>(f * kDofs)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(FindMotionNoise, TellsNoiseFromMotion) {
  constexpr double kChange = 0.02;
  for (const double deviation : {0.02, 0.05, 0.2}) {
    Noise noise(7);
    Course course;
    for (const double x : Wandering(400, kChange, 0, &noise)) {
      // The variances that are claimed are wrong by a factor of four.
      course.values.push_back(x + deviation * noise.Draw());
      course.variances.push_back(deviation * deviation / 4);
    }
    const MotionNoise found = FindMotionNoise(course);
    EXPECT_NEAR(std::sqrt(found.noise), 2, 0.3) << deviation;
    EXPECT_NEAR(std::sqrt(found.jerk), kChange, 0.4 * kChange) << deviation;
  }
}

TEST(FindMotionNoise, AFewHitsAreMotionAndNotNoise) {
  Noise noise(3);
  Course course;
  double at = 0, speed = 0.2;
  for (int f = 0; f < 200; ++f) {
    if (f % 40 == 20) speed = -speed;
    at += speed;
    course.values.push_back(at + 0.01 * noise.Draw()), course.variances.push_back(1e-4);
  }
  const MotionNoise found = FindMotionNoise(course);
  EXPECT_NEAR(std::sqrt(found.noise), 1, 0.2);
  EXPECT_LT(std::sqrt(found.jerk), 0.02);  // a hit changes the speed by 0.4
}

TEST(CalmTake, ErrorsFallByWhatTheBestEstimateAllows) {
  Noise noise(11);
  const int frames = 120;
  const double jerk = 0.004, deviation = 0.01;
  const std::vector<BodyPose> truth = WanderingPoses(frames, jerk, &noise);
  const std::vector<FittedFrame> fitted = Fitted(truth, deviation, &noise);
  const double before = ErrorOf(PosesOf(fitted), truth);
  const double after = ErrorOf(CalmTake(fitted, 1).poses, truth);
  // The least variance of an estimate of one number, from the dense inverse, where both variances
  // are known; neighbours in the pose are correlated, so that it is only nearly this.
  const double measured = before * before;
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(frames, frames) / measured;
  for (int f = 0; f + kJerk < frames; ++f) {
    const Eigen::Vector4d c(kJerkWeights.data());
    information.block<4, 4>(f, f) += c * c.transpose() / (jerk * jerk);
  }
  const double best = std::sqrt(information.inverse().diagonal().mean());
  EXPECT_LT(best, 0.65 * before);
  EXPECT_LT(after, 1.1 * best);
}

TEST(CalmTake, AHardStopStaysInItsFrame) {
  Noise noise(5);
  std::vector<BodyPose> truth(60);
  constexpr int kStop = 30;
  for (int f = 0; f < 60; ++f) truth[f].q[Elbow()] = 0.1 * std::min(f, kStop);
  const double deviation = 0.01;
  const CalmedTake calmed = CalmTake(Fitted(truth, deviation, &noise), 1);
  // Means over five frames would be off by 0.06 there, six standard deviations of a fit.
  for (int f = kStop - 4; f <= kStop + 4; ++f)
    EXPECT_NEAR(calmed.poses[f].q[Elbow()], truth[f].q[Elbow()], 2 * deviation) << f;
  EXPECT_LT(ErrorOf(calmed.poses, truth), 0.5 * deviation);
}

TEST(CalmTake, FramesThatTellNothingOfAnArmComeFromTheirNeighbours) {
  Noise noise(9);
  std::vector<BodyPose> truth(60);
  for (int f = 0; f < 60; ++f) truth[f].q[Elbow()] = 1 + 0.8 * std::sin(0.1 * f);
  std::vector<FittedFrame> fitted = Fitted(truth, 0.01, &noise);
  for (int f = 30; f < 36; ++f) {
    fitted[f].evidence.matrix.row(Elbow()).setZero(),
        fitted[f].evidence.matrix.col(Elbow()).setZero();
    fitted[f].pose.q[Elbow()] += 0.15;
  }
  const CalmedTake calmed = CalmTake(fitted, 1);
  for (int f = 28; f < 38; ++f)
    EXPECT_NEAR(calmed.poses[f].q[Elbow()], truth[f].q[Elbow()], 0.05) << f;
}

TEST(CalmTake, AnActorWhoTurnsRoundAndRoundIsLeftAsHeIs) {
  std::vector<FittedFrame> fitted;
  for (int f = 0; f < 50; ++f) {
    FittedFrame frame;
    frame.pose.root_chart =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * f, Eigen::Vector3d(0.1, 0.2, 1).normalized()));
    frame.pose.q[0] = 0.02 * f;
    frame.evidence.matrix = 1e4 * DofMatrix::Identity();
    fitted.push_back(frame);
  }
  const CalmedTake calmed = CalmTake(fitted, 1);
  for (int f = 0; f < 50; ++f) {
    const auto& turned = calmed.poses[f];
    EXPECT_LT(turned.RootRotation().angularDistance(fitted[f].pose.RootRotation()), 1e-6) << f;
    EXPECT_LT((turned.q - fitted[f].pose.q).norm(), 1e-6) << f;
  }
}

TEST(CalmTake, StrengthIsAFactorOnTheNoise) {
  Noise noise(13);
  const std::vector<BodyPose> truth = WanderingPoses(60, 0.004, &noise);
  const std::vector<FittedFrame> fitted = Fitted(truth, 0.01, &noise);
  const auto moved = [&](double strength) {
    return ErrorOf(CalmTake(fitted, strength).poses, PosesOf(fitted));
  };
  EXPECT_LT(moved(0.01), 0.02 * moved(1));
  EXPECT_GT(moved(4), 1.05 * moved(1));
}

TEST(CalmTake, AFewFramesAreLeftAsTheyAre) {
  Noise noise(2);
  const std::vector<BodyPose> truth = WanderingPoses(kLeastFrames - 1, 0.01, &noise);
  const std::vector<FittedFrame> fitted = Fitted(truth, 0.01, &noise);
  const CalmedTake calmed = CalmTake(fitted, 1);
  for (std::size_t f = 0; f < fitted.size(); ++f) EXPECT_EQ(calmed.poses[f].q, fitted[f].pose.q);
}

TEST(CalmTake, SameBitsForAnyThreadCount) {
  Noise noise(4);
  const std::vector<BodyPose> truth = WanderingPoses(30, 0.01, &noise);
  const std::vector<FittedFrame> fitted = Fitted(truth, 0.01, &noise);
  SetThreadCount(1);
  const CalmedTake one = CalmTake(fitted, 1);
  SetThreadCount(3);
  const CalmedTake three = CalmTake(fitted, 1);
  SetThreadCount(0);
  for (std::size_t f = 0; f < fitted.size(); ++f) {
    EXPECT_EQ(one.poses[f].q, three.poses[f].q);
    EXPECT_EQ(one.poses[f].root_chart.coeffs(), three.poses[f].root_chart.coeffs());
  }
}

}  // namespace keypose::fit::calm_test
