#include "motion/tracking/calm_take.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/numbers/parallel.h"
#include "motion/tracking/testing/wandering.h"

namespace keypose::motion::calm_take_test {

/// The place of the left elbow in a pose.
int Elbow() { return Joints()[kElbowL].first_dof; }

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

}  // namespace keypose::motion::calm_take_test
