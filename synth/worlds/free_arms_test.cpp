// Arms that would pass through the trunk, the thighs or the head are turned out of them.
#include "synth/worlds/free_arms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "synth/worlds/performer.h"

namespace keypose::synth::free_arms_test {

constexpr int kFrames = 70, kApart = 12;

int ColumnOf(const MotionClip& clip, const std::string& name, BvhChannel channel) {
  int column = 0;
  for (const ClipJoint& joint : clip.joints)
    for (const BvhChannel of_joint : joint.channels) {
      if (joint.name == name && of_joint == channel) return column;
      ++column;
    }
  return -1;
}

/// The left forearm swings from the side into the belly and back; it is apart from the trunk at
/// the beginning and at the end.
MotionClip HandInBelly() {
  MotionClip clip = MakeOwnMotion(kFrames, 30, 1);
  clip.values.setZero();
  const int column = ColumnOf(clip, "LeftElbow", BvhChannel::kZrotation);
  for (int f = 0; f < kFrames; ++f) {
    const double way = std::clamp(std::min(f - kApart, kFrames - 1 - kApart - f) / 15.0, 0.0, 1.0);
    clip.values(f, column) = 40 - 130 * way * way * (3 - 2 * way);
  }
  return clip;
}

struct Body {
  MotionClip clip = HandInBelly();
  std::vector<Rigid3> bind;
  std::vector<Flesh> lumps;

  Body() {
    MotionClip still = clip;
    still.values = Eigen::MatrixXd::Zero(1, clip.channel_count());
    bind = UprightFrames(still, 0);
    Put("Chest", "Hips", "Neck", 0.12);
    for (const std::string side : {"Left", "Right"}) {
      Put(side + "Shoulder", side + "Shoulder", side + "Elbow", 0.05);
      Put(side + "Elbow", side + "Elbow", side + "Wrist", 0.03);
    }
  }
  void Put(const std::string& joint, const std::string& from, const std::string& to, double r) {
    Flesh lump;
    lump.joint = clip.Find(joint);
    lump.a = bind[clip.Find(from)].translation;
    lump.b = bind[clip.Find(to)].translation;
    lump.ra = lump.rb = r;
    lumps.push_back(lump);
  }
  Eigen::Vector3d At(const std::string& joint, int frame) const {
    return UprightFrames(clip, frame)[clip.Find(joint)].translation;
  }
  /// Least distance of the left forearm's outer half from the trunk's surface.
  double Clearance(int frame) const {
    const std::vector<Rigid3> frames = UprightFrames(clip, frame);
    Flesh trunk = lumps[0];
    const Rigid3 move = Compose(frames[trunk.joint], bind[trunk.joint].Inverse());
    trunk.a = move * trunk.a, trunk.b = move * trunk.b;
    double least = 1e9;
    for (const double t : {0.4, 0.6, 0.8, 1.0})
      least = std::min(least, BodyDistance({trunk}, (1 - t) * At("LeftElbow", frame) +
                                                        t * At("LeftWrist", frame)));
    return least;
  }
  double LeastClearance() const {
    double least = 1e9;
    for (int f = 0; f < kFrames; ++f) least = std::min(least, Clearance(f));
    return least;
  }
};

TEST(FreeArms, AHandInTheBellyComesOut) {
  Body body;
  ASSERT_LT(body.LeastClearance(), -0.05);
  FreeArms(body.lumps, body.bind, &body.clip);
  constexpr double kPressed = 0.015, kLeft = 0.002;
  EXPECT_GT(body.LeastClearance(), kPressed - kLeft);
}

/// The left arm sinks from the side to its place in the bind pose and back.
MotionClip ArmSinks() {
  MotionClip clip = MakeOwnMotion(kFrames, 30, 1);
  clip.values.setZero();
  const int column = ColumnOf(clip, "LeftShoulder", BvhChannel::kZrotation);
  for (int f = 0; f < kFrames; ++f) {
    const double way = std::clamp(std::min(f - kApart, kFrames - 1 - kApart - f) / 15.0, 0.0, 1.0);
    clip.values(f, column) = 50 * (1 - way * way * (3 - 2 * way));
  }
  return clip;
}

/// Least distance from the surface of a ball of 8 cm, 3 cm beside the place of one of the left
/// arm's joints in the bind pose.
/// @param fixed_to  the joint that the ball is part of
double LeastFromBall(const std::string& arm_joint, const std::string& fixed_to, bool freed) {
  Body body;
  body.clip = ArmSinks();
  Flesh ball;
  ball.joint = body.clip.Find(fixed_to);
  ball.a = body.bind[body.clip.Find(arm_joint)].translation + Eigen::Vector3d(0, 0.03, 0);
  ball.b = ball.a, ball.ra = ball.rb = 0.08;
  body.lumps.push_back(ball);
  if (freed) FreeArms(body.lumps, body.bind, &body.clip);
  double least = 1e9;
  for (int f = 0; f < kFrames; ++f) {
    const Rigid3 move =
        Compose(UprightFrames(body.clip, f)[ball.joint], body.bind[ball.joint].Inverse());
    Flesh here = ball;
    here.a = here.b = move * ball.a;
    least = std::min(least, FleshDistance(here, body.At(arm_joint, f)));
  }
  return least;
}

TEST(FreeArms, AnElbowInAThighAndAHandInTheHeadComeOut) {
  constexpr double kUpperArm = 0.025, kForearm = 0.015, kLeft = 0.002;  // [m]; half of the radii
  for (const char* joint : {"LeftHip", "RightHip"}) {
    EXPECT_LT(LeastFromBall("LeftElbow", joint, false), -0.04);
    EXPECT_GT(LeastFromBall("LeftElbow", joint, true), kUpperArm - kLeft);
  }
  EXPECT_LT(LeastFromBall("LeftWrist", "Head", false), -0.04);
  EXPECT_GT(LeastFromBall("LeftWrist", "Head", true), kForearm - kLeft);
}

TEST(FreeArms, AnElbowBesideTheTrunkStays) {
  EXPECT_EQ(LeastFromBall("LeftElbow", "Chest", false), LeastFromBall("LeftElbow", "Chest", true));
}

TEST(FreeArms, WhatWasOutsideKeepsItsBits) {
  const Body before;
  Body body;
  FreeArms(body.lumps, body.bind, &body.clip);
  EXPECT_EQ(body.clip.values.topRows(2), before.clip.values.topRows(2));
  EXPECT_EQ(body.clip.values.bottomRows(2), before.clip.values.bottomRows(2));
  const int elbow = ColumnOf(body.clip, "LeftElbow", BvhChannel::kZrotation);
  EXPECT_EQ(body.clip.values.col(elbow), before.clip.values.col(elbow)) << "shoulders alone turn";
  for (int f = 0; f < kFrames; ++f) EXPECT_EQ(body.At("RightWrist", f), before.At("RightWrist", f));
}

/// Largest second difference of the wrist's places [m].
double Roughness(const Body& body) {
  double worst = 0;
  for (int f = 1; f + 1 < kFrames; ++f)
    worst = std::max(worst, (body.At("LeftWrist", f - 1) - 2 * body.At("LeftWrist", f) +
                             body.At("LeftWrist", f + 1))
                                .norm());
  return worst;
}

TEST(FreeArms, TheMotionStaysSmooth) {
  Body body;
  const double before = Roughness(body);
  FreeArms(body.lumps, body.bind, &body.clip);
  EXPECT_LT(Roughness(body), 1.3 * before);
}

TEST(FreeArms, TheSameBitsForAnyThreadCount) {
  Body one, three;
  const int before = ThreadCount();
  SetThreadCount(1);
  FreeArms(one.lumps, one.bind, &one.clip);
  SetThreadCount(3);
  FreeArms(three.lumps, three.bind, &three.clip);
  SetThreadCount(before);
  EXPECT_EQ(one.clip.values, three.clip.values);
}

TEST(FreeArms, AShoulderMustTurnAboutThreeAxes) {
  Body body;
  body.clip.joints[body.clip.Find("LeftShoulder")].channels.pop_back();
  EXPECT_THROW(FreeArms(body.lumps, body.bind, &body.clip), InputError);
}

}  // namespace keypose::synth::free_arms_test
