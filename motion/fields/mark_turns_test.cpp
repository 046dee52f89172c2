#include "motion/fields/mark_turns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/numbers/rotations.h"
#include "core/values/angles.h"
#include "motion/testing/marked_bar.h"
#include "motion/testing/rigged_scan.h"

namespace keypose::motion::mark_turns_test {

/// How far the ring of the bar at this height has turned about z: by its mean vector along x.
double RingAngle(const PointsX3& rest, const PointsX3& pose, double z) {
  Eigen::RowVector3d along = Eigen::RowVector3d::Zero();
  for (Eigen::Index i = 0; i < rest.rows(); ++i)
    if (std::abs(rest(i, 2) - z) < 1e-6) along += rest(i, 0) * pose.row(i);
  return std::atan2(along[1], along[0]);
}

TEST(WithAgreeingSigns, SignsOfInputsDoNotMatter) {
  const Mesh bar = MakeBar();
  std::vector<MarkPlace> places;
  for (double z : {0.1, 0.6, 1.0, 1.5, 1.9})
    places.push_back({FaceNear(bar, {0.05, 0, z}), Eigen::Vector3d::Constant(1.0 / 3)});
  const MarkTree tree = JoinMarks(bar.points, bar.faces, places);
  std::vector<Eigen::Quaterniond> rotations;
  for (double angle : {-1.6, -0.4, 0.0, 1.3, 2.9})
    rotations.push_back(QuaternionOf({0.2 * angle, 0.1, angle}));
  const auto agreeing = WithAgreeingSigns(tree, rotations);
  TurnFollower follower(tree);
  const MarkTurns turns = follower.Next(rotations);
  for (int flips = 0; flips < 32; ++flips) {
    std::vector<Eigen::Quaterniond> flipped = rotations;
    for (int k = 0; k < 5; ++k)
      if (flips >> k & 1) flipped[k].coeffs() = -flipped[k].coeffs();
    const auto same = WithAgreeingSigns(tree, flipped);
    for (int k = 0; k < 5; ++k) EXPECT_EQ(same[k].coeffs(), agreeing[k].coeffs());
    TurnFollower again(tree);
    const MarkTurns as_before = again.Next(flipped);
    EXPECT_EQ(as_before.turns, turns.turns);
    EXPECT_EQ(as_before.body, turns.body);
  }
}

TEST(TurnFollower, TurnsOfMoreThanHalfATurnBetweenMarksAreFollowed) {
  // The bar's end makes one and a half turns in 18 frames; its marks are far apart.
  const Mesh bar = MakeBar(120);
  std::vector<Mark> marks = MarksAlong(bar, {0.1, 0.3, 0.5, 1.9});
  for (double z : {0.5, 1.9}) marks.push_back(OnBoth(FaceNear(bar, {-0.05, 0, z})));
  std::vector<PointsX3> poses;
  for (int t = 0; t <= 18; ++t) {
    PointsX3 pose = bar.points;
    for (Eigen::Index i = 0; i < pose.rows(); ++i) {
      const double share = std::clamp((pose(i, 2) - 0.5) / 1.4, 0.0, 1.0);
      pose.row(i) = bar.points.row(i) * ExpOf({0, 0, share * t * kPi / 6}).transpose();
    }
    poses.push_back(pose);
  }
  TransferOptions options;
  options.feet = options.volume = false;
  Transfer transfer(bar, bar.points, bar.faces, marks, options);
  for (const PointsX3& pose : poses) transfer.Add(pose, "frame");
  EXPECT_NEAR(transfer.report().largest_turn_between, 3 * kPi, 0.1);
  const PointsX3 late = transfer.Frame(14);
  // Half-way between the marks, at z = 1.2, the bar has turned by half of 420 degrees.
  const double turned = RingAngle(bar.points, late, 1.2);
  EXPECT_NEAR(std::remainder(turned - 7 * kPi / 6, 2 * kPi), 0, 0.2);
  options.follow = false;
  const auto shortest = Transferred(bar, bar.points, bar.faces, marks, poses, options);
  // The short way, half of 60 degrees, is another pose.
  const double short_way = RingAngle(bar.points, shortest[14], 1.2);
  EXPECT_GT(std::abs(std::remainder(short_way - turned, 2 * kPi)), 1);
}

}  // namespace keypose::motion::mark_turns_test
