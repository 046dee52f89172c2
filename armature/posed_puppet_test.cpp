// The posed puppet: timing of curves, its text, its clip, its pictures.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "armature/example/theropod.h"
#include "armature/live/joint_timing.h"
#include "armature/live/latency.h"
#include "armature/live/plate_view.h"
#include "armature/live/pose_text.h"
#include "armature/live/posed_puppet.h"
#include "armature/skinning/stick_mesh.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature::posed_puppet_test {

using Eigen::MatrixXd;
using Eigen::Vector3d;

MatrixXd Column(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), SizeOf(values));
}

TEST(FilmValues, HoldRepeatsEachFrameToTheBit) {
  const MatrixXd film = FilmValues(Column({0.1, 0.7, 0.3}), 2, Between::kHold);
  EXPECT_EQ(film, Column({0.1, 0.1, 0.7, 0.7, 0.3, 0.3}));
}

TEST(FilmValues, LinearPassesAtEvenPace) {
  const MatrixXd film = FilmValues(Column({0, 3, 0}), 3, Between::kLinear);
  EXPECT_TRUE(film.isApprox(Column({0, 1, 2, 3, 2, 1, 0})));
}

TEST(FilmValues, SmoothPassesTheKeysAndNeverBeyondThem) {
  const std::vector<double> keys = {0, 0.1, 2, 2, 2, -1, 5, 5.01};
  const MatrixXd film = FilmValues(Column(keys), 10, Between::kSmooth);
  ASSERT_EQ(film.rows(), 71);
  for (int f = 0; f < 71; ++f) {
    const double a = keys[f / 10], b = keys[std::min(f / 10 + 1, 7)];
    EXPECT_GE(film(f), std::min(a, b) - 1e-12) << f;
    EXPECT_LE(film(f), std::max(a, b) + 1e-12) << f;
    if (f % 10 == 0) {
      EXPECT_EQ(film(f), a);
    }
    if (f >= 20 && f <= 40) {
      EXPECT_EQ(film(f), 2) << "a joint that stands still stays still";
    }
  }
  // No corner at a key that is passed: the pace before and behind it agree.
  const MatrixXd passing = FilmValues(Column({0, 1, 2.5}), 100, Between::kSmooth);
  EXPECT_NEAR(passing(101) - passing(100), passing(100) - passing(99), 1e-3);
}

/// The largest change of pace from one frame of the film to the next: at recorded frames that are
/// passed, and elsewhere.
std::pair<double, double> PaceJumps(const MatrixXd& film, int step) {
  double at_keys = 0, elsewhere = 0;
  for (Eigen::Index f = 1; f + 1 < film.rows(); ++f) {
    const double jump = std::abs(film(f + 1) - 2 * film(f) + film(f - 1));
    double& most = f % step == 0 ? at_keys : elsewhere;
    most = std::max(most, jump);
  }
  return {at_keys, elsewhere};
}

TEST(FilmValues, SmoothHasNoSeamWherePacesChange) {
  std::vector<double> swing;
  for (int f = 0; f < 24; ++f) swing.push_back(std::sin(0.5 * f) + 0.3 * std::sin(1.3 * f));
  const auto [smooth_at, smooth_elsewhere] =
      PaceJumps(FilmValues(Column(swing), 8, Between::kSmooth), 8);
  EXPECT_LT(smooth_at, smooth_elsewhere);
  const auto [even_at, even_elsewhere] =
      PaceJumps(FilmValues(Column(swing), 8, Between::kLinear), 8);
  EXPECT_GT(even_at, 1000 * even_elsewhere) << "as a test of the measure";
}

TEST(FilmValues, AnUnknownWayIsRefused) {
  EXPECT_EQ(BetweenNamed("smooth"), Between::kSmooth);
  EXPECT_THROW(BetweenNamed("jumps"), UsageError);
}

TEST(FilmValues, OneFrameIsOneFrame) {
  EXPECT_EQ(FilmValues(Column({4}), 5, Between::kSmooth).rows(), 1);
  EXPECT_EQ(FilmValues(Column({4}), 5, Between::kHold).rows(), 5);
}

TEST(Smoothed, NoiseShrinksAndStopsStay) {
  std::vector<double> noisy, clean;
  for (int f = 0; f < 60; ++f) {
    clean.push_back(f < 30 ? 0.1 * f : 3);
    noisy.push_back(clean.back() + (f < 30 ? 0.02 * (f % 2 ? 1 : -1) : 0));
  }
  const MatrixXd smooth = Smoothed(Column(noisy), 2);
  double before = 0, after = 0;
  for (int f = 4; f < 26; ++f) {
    before += std::abs(noisy[f] - clean[f]);
    after += std::abs(smooth(f) - clean[f]);
  }
  EXPECT_LT(after, 0.2 * before);
  for (int f = 31; f < 60; ++f) EXPECT_EQ(smooth(f), 3) << f;
  EXPECT_EQ(smooth(0), noisy[0]);
}

TEST(Latency, SharesOfWhatWasMeasured) {
  Latency latency;
  EXPECT_EQ(latency.At(0.5), 0);
  for (int i = 100; i >= 1; --i) latency.Add(i);
  EXPECT_EQ(latency.At(0.5), 50);
  EXPECT_EQ(latency.At(0.99), 99);
  EXPECT_EQ(latency.At(1), 100);
}

/// The generated theropod as ball and stick.
PuppetParts TheropodParts() {
  PuppetParts parts;
  parts.armature = MakeTheropod();
  parts.plan = MakeTheropodChains(parts.armature);
  parts.skeleton = SkeletonOfClip(MakeTheropodSkeleton(), false);
  parts.world_from_armature = PlacementOf(parts.armature, parts.plan, parts.skeleton, false);
  StickFigure figure = MakeStickFigure(SkinBonesOf(parts.skeleton));
  parts.mesh = figure.mesh;
  parts.weights = figure.weights;
  return parts;
}

TEST(PosedPuppet, TheropodWalksWithItsFeetWhereTheArmatureHasThem) {
  const PuppetParts parts = TheropodParts();
  EXPECT_NEAR(parts.world_from_armature.scale, 1, 0.02);
  PosedPuppet puppet(parts);
  for (double time = 0; time < 1.2; time += 0.05) {
    const auto values = TheropodWalk(parts.armature, time);
    puppet.Update(values);
    const auto frames = ForwardKinematics(parts.armature, values);
    for (const ChainState& chain : puppet.matcher().chains()) {
      const bool leg = chain.name.find("Leg") != std::string::npos;
      const double limit = leg ? 0.02 : 1e-9;  // legs are one to one, and a little shorter
      if (chain.name == "neck" || chain.name == "tail" || leg) {
        EXPECT_LT(chain.match.far_gap, limit * chain.chain_length) << chain.name;
      }
    }
    const Vector3d tip =
        parts.world_from_armature * frames[parts.armature.Find("tailRod9")].translation;
    EXPECT_LT((puppet.matcher().pose().joints.row(parts.skeleton.Find("TailTip")).transpose() - tip)
                  .norm(),
              1e-9);
  }
}

TEST(PosedPuppet, NothingMovesWhenNoValueChanged) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  const auto values = TheropodWalk(parts.armature, 0.3);
  puppet.Update(values);
  const PointsX3 before = puppet.points();
  puppet.Update(values);
  EXPECT_FALSE(puppet.matcher().moved());
  EXPECT_EQ(before, puppet.points());
}

TEST(PosedPuppet, MovingAPartGivesTheBitsOfMovingAll) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  auto values = TheropodWalk(parts.armature, 0.3);
  puppet.Update(values);
  for (const char* name : {"tailBend7", "leftKneeBend", "trunkSide6"}) {
    values[parts.armature.JointOf(parts.armature.Find(name))] += 0.2;
    puppet.Update(values);
    PointsX3 whole;
    Skin(parts.mesh.points, parts.weights, parts.skeleton.size())
        .Pose(puppet.matcher().pose().bones, &whole);
    EXPECT_EQ(puppet.points(), whole) << name;
  }
}

TEST(Skeleton, TheropodsOwnIsOneTreeThatFollowsToTheBit) {
  PuppetParts parts = TheropodParts();
  for (Chain& chain : parts.plan.chains) chain.computer.clear();
  const std::vector<double> zero(parts.armature.joints.size(), 0);
  parts.skeleton =
      SkeletonOfArmature(parts.armature, parts.plan, ForwardKinematics(parts.armature, zero));
  parts.world_from_armature = {};
  int roots = 0;
  for (const SkeletonJoint& joint : parts.skeleton.joints) roots += joint.parent < 0;
  EXPECT_EQ(roots, 1);
  PuppetMatcher matcher(parts.armature, parts.plan, parts.skeleton, {}, {});
  const auto values = TheropodWalk(parts.armature, 0.4);
  const SkeletonPose& pose = matcher.Update(values);
  const auto frames = ForwardKinematics(parts.armature, values);
  for (const Anchor& anchor : parts.plan.anchors) {
    const Vector3d joint = pose.joints.row(parts.skeleton.Find(anchor.computer));
    EXPECT_LT((joint - frames[anchor.node].translation).norm(), 1e-9) << anchor.name;
  }
}

TEST(LeadingBones, GoOnAlongTheLongestRow) {
  const Skeleton skeleton = TheropodParts().skeleton;
  const auto leading = LeadingBones(skeleton);
  EXPECT_EQ(leading[skeleton.Find("Hips")], skeleton.Find("Tail1"));
  EXPECT_EQ(leading[skeleton.Find("Neck1")], skeleton.Find("Neck2"));
  EXPECT_EQ(leading[skeleton.Find("HeadTip")], skeleton.Find("HeadTip"));
}

TEST(SkeletonClip, JointsTurnAsTheBonesDo) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  std::vector<SkeletonPose> poses;
  for (int f = 0; f < 12; ++f) {
    puppet.Update(TheropodWalk(parts.armature, 0.1 * f));
    poses.push_back(puppet.matcher().pose());
  }
  const MotionClip clip = SkeletonClip(parts.skeleton, poses, 24);
  ASSERT_EQ(clip.frame_count(), 12);
  for (int f = 0; f < 12; ++f) {
    const auto frames = JointFrames(clip, f);
    for (const char* name : {"HeadTip", "TailTip"}) {
      const Vector3d place = poses[f].joints.row(parts.skeleton.Find(name));
      EXPECT_LT((frames[clip.Find(name)].translation - place).norm(), 1e-9) << name << f;
    }
    if (f > 0) {
      const double step = (clip.values.row(f) - clip.values.row(f - 1)).cwiseAbs().maxCoeff();
      EXPECT_LT(step, 60) << "angles do not jump by whole turns";
    }
  }
}

TEST(PoseJson, IsALineThatParses) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  puppet.Update(TheropodWalk(parts.armature, 0.2));
  const std::string line = PoseJson(parts.skeleton, puppet.matcher(), {1.5, 7, true, 0.002});
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json["pose"], 7);
  EXPECT_EQ(json["matched"], 6);
  EXPECT_EQ(json["joints"].size(), parts.skeleton.joints.size());
  const auto head = json["joints"]["HeadTip"];
  const int joint = parts.skeleton.Find("HeadTip");
  EXPECT_NEAR(head[1].get<double>(), puppet.matcher().pose().joints(joint, 1), 1e-5);
}

TEST(DrawPuppet, PuppetCoversThePlateAndTheSetIsGlass) {
  const Mesh ball = MakeIcosphere(3);
  Mesh wall = MakeBox(4, 0.1, 4);
  wall.points.rowwise() += Eigen::RowVector3d(0, -2, -2);  // before the right half of the ball
  const Image8 none;
  PlateView where;
  where.view = FitView(PointsX3(3 * ball.points), 0, 1, 96, 96);
  where.plate = Image8(96, 96, 3, 40);
  const Mesh nothing;
  const Image8 alone = DrawPuppet({ball, none, nothing}, where, ball.points, {});
  EXPECT_EQ(alone.at(3, 3)[0], 40);
  EXPECT_GT(alone.at(48, 48)[0], 80);
  const Image8 with_set = DrawPuppet({ball, none, wall}, where, ball.points, {});
  EXPECT_EQ(with_set.at(40, 48)[0], alone.at(40, 48)[0]);  // left of the wall
  EXPECT_NE(with_set.at(90, 48)[0], 40);                   // the wall over the plate
  EXPECT_NE(with_set.at(56, 48)[0], alone.at(56, 48)[0]);  // the ball behind the wall
  PointsX3 before = ball.points;
  before.col(0).array() -= 1.6;
  const Image8 ghost = DrawPuppet({ball, none, nothing}, where, ball.points, {&before});
  int changed = 0;
  for (std::size_t i = 0; i < ghost.data.size(); ++i) changed += ghost.data[i] != alone.data[i];
  EXPECT_GT(changed, 300);
  where.plate = Image8(64, 96, 3, 40);
  EXPECT_THROW(DrawPuppet({ball, none, nothing}, where, ball.points, {}), InputError);
}

TEST(DrawPuppet, CharacterIsPlacedInTheWorld) {
  const Mesh ball = MakeIcosphere(2);
  const Image8 none;
  const Mesh nothing;
  PlateView where;
  where.view = FitView(PointsX3(3 * ball.points), 0, 1, 64, 64);
  where.world_from_character.scale = 0.1;
  where.world_from_character.translation = Vector3d(2, 0, 0);
  const Image8 picture = DrawPuppet({ball, none, nothing}, where, ball.points, {});
  const Image8 empty =
      DrawPuppet({ball, none, nothing}, where, PointsX3(ball.points.array() + 1e3), {});
  EXPECT_EQ(picture.at(32, 32)[0], empty.at(32, 32)[0]);
  EXPECT_NE(picture.data, empty.data);
}

}  // namespace keypose::armature::posed_puppet_test
