// Frames between several keys: their pace, volume, pins, trajectories and turns.
#include "interpolate/surface/key_source.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "interpolate/surface/arap.h"
#include "interpolate/testing/played_poses.h"
#include "interpolate/timing/easing.h"

namespace keypose::interpolation::key_source_test {

/// Velocities [frame^-1] of all vertices just before and just after the key that ends `span`.
struct PaceAtKey {
  PointsX3 before, after;
  double Jump() const {
    return (after - before).rowwise().norm().maxCoeff() / before.rowwise().norm().maxCoeff();
  }
};

PaceAtKey PaceBetween(FrameSource& source, const Schedule& schedule, int in, int out,
                      const PointsX3& key) {
  // One-sided differences of second order in time.
  const double h = 1e-3;
  const auto at = [&](int span, double share) {
    const Span& s = schedule.spans[span];
    return source.At(span, {EaseAt(s.ease, share)})[0].points;
  };
  PaceAtKey pace;
  pace.before =
      (3 * key - 4 * at(in, 1 - h) + at(in, 1 - 2 * h)) / (2 * h * schedule.spans[in].frames);
  pace.after = (-3 * key + 4 * at(out, h) - at(out, 2 * h)) / (2 * h * schedule.spans[out].frames);
  return pace;
}

TEST(KeySource, TwoKeysGoTheWayOfTwoKeys) {
  const Poses p;
  const Schedule schedule = MakeSchedule({9});
  KeySource source({p.a, p.b}, p.mesh.faces, schedule, PlainRules(schedule, false));
  ArapOptions options;
  options.correct_volume = false;
  const ArapInterpolator pair(p.a, p.b, p.mesh.faces, options);
  const auto frames = source.At(0, {0.1, 0.5, 0.8});
  EXPECT_LT(Gap(frames[0].points, pair.At(0.1)), 1e-12);
  EXPECT_LT(Gap(frames[1].points, pair.At(0.5)), 1e-12);
  EXPECT_LT(Gap(frames[2].points, pair.At(0.8)), 1e-12);
}

TEST(KeySource, PaceDoesNotJumpAtKeys) {
  const Poses p;
  // Spans of unlike length, and unlike eases that do not stop at the key.
  Timeline timeline = At({0, 0.7, 2});
  timeline.keys[0].ease = {0.3, 0.1, 0.6, 0.8};
  timeline.keys[1].ease = {0.5, 0.3, 0.5, 1};
  for (const bool overshoot : {false, true}) {
    timeline.overshoot = overshoot;
    const Schedule schedule = ScheduleOf(timeline);
    KeySource source(p.all(), p.mesh.faces, schedule, PlainRules(schedule, true));
    const PaceAtKey pace = PaceBetween(source, schedule, 0, 1, p.b);
    EXPECT_LT(pace.Jump(), 1e-3);
    EXPECT_GT(pace.before.rowwise().norm().maxCoeff(),
              0.01);  // not by standing still
  }
}

TEST(KeySource, PaceJumpsWhereSpansAreLinear) {
  const Poses p;
  Timeline timeline = At({0, 0.7, 2});
  for (TimelineKey& key : timeline.keys) key.travel = Travel::kLinear;
  const Schedule schedule = ScheduleOf(timeline);
  KeySource source(p.all(), p.mesh.faces, schedule, PlainRules(schedule, true));
  EXPECT_GT(PaceBetween(source, schedule, 0, 1, p.b).Jump(), 0.1);
}

TEST(KeySource, PaceDoesNotJumpAtTheSeamOfALoop) {
  const Poses p;
  Timeline timeline = At({0, 0.8, 1.7, 2.5});
  timeline.loop = timeline.overshoot = true;
  const std::vector<PointsX3> keys = {p.a, p.b, p.c, p.a};
  const Schedule schedule = ScheduleOf(timeline);
  KeySource source(keys, p.mesh.faces, schedule, PlainRules(schedule, true));
  const PaceAtKey seam = PaceBetween(source, schedule, 2, 0, p.a);
  EXPECT_LT(seam.Jump(), 1e-3);
  EXPECT_GT(seam.before.rowwise().norm().maxCoeff(), 0.01);
  timeline.loop = false;
  const Schedule open = ScheduleOf(timeline);
  KeySource without(keys, p.mesh.faces, open, PlainRules(open, true));
  EXPECT_GT(PaceBetween(without, open, 2, 0, p.a).Jump(), 0.1);
}

TEST(KeySource, ComesToRestAtHoldsAndExtremes) {
  const Poses p;
  Timeline timeline = At({0, 1, 2});
  timeline.keys[1].hold_s = 0.3;
  const Schedule held = ScheduleOf(timeline);
  KeySource holding(p.all(), p.mesh.faces, held, PlainRules(held, true));
  const PaceAtKey rest = PaceBetween(holding, held, 0, 1, p.b);
  const double speed = Gap(p.a, p.b) * BoundingDiagonal(p.b) / held.spans[0].frames;
  EXPECT_LT(rest.before.rowwise().norm().maxCoeff(), 1e-3 * speed);
  EXPECT_LT(rest.after.rowwise().norm().maxCoeff(), 1e-3 * speed);
  // There and back: the far key is an extreme, and no frame goes beyond it.
  const Schedule back = ScheduleOf(At({0, 1, 2}));
  KeySource returning({p.a, p.b, p.a}, p.mesh.faces, back, PlainRules(back, true));
  EXPECT_LT(PaceBetween(returning, back, 0, 1, p.b).before.rowwise().norm().maxCoeff(),
            1e-3 * speed);
}

TEST(KeySource, ReversingTheKeysReversesTime) {
  const Poses p;
  Timeline timeline = At({0, 0.7, 2}), reverse = At({0, 1.3, 2});
  const Schedule there = ScheduleOf(timeline), back = ScheduleOf(reverse);
  KeySource forward(p.all(), p.mesh.faces, there, PlainRules(there, true));
  KeySource backward({p.c, p.b, p.a}, p.mesh.faces, back, PlainRules(back, true));
  for (const double way : {0.1, 0.5, 0.9}) {
    EXPECT_LT(Gap(forward.At(0, {way})[0].points, backward.At(1, {1 - way})[0].points), 1e-10);
    EXPECT_LT(Gap(forward.At(1, {way})[0].points, backward.At(0, {1 - way})[0].points), 1e-10);
  }
}

TEST(KeySource, FramesTendToTheKeysThatTheyAdjoin) {
  const Poses p;
  const Schedule schedule = ScheduleOf(At({0, 0.7, 2}));
  KeySource source(p.all(), p.mesh.faces, schedule, PlainRules(schedule, true));
  EXPECT_LT(Gap(source.At(0, {1 - 1e-9})[0].points, p.b), 1e-8);
  EXPECT_LT(Gap(source.At(1, {1e-9})[0].points, p.b), 1e-8);
  EXPECT_LT(Gap(source.At(1, {1 - 1e-9})[0].points, p.c), 1e-8);
}

TEST(KeySource, TurnsAddUpOverKeys) {
  // 0, 270 and 540 degrees: the last key relative to the first winds one and a half times.
  const Mesh mesh = MakeCylinder(0.08, 2, 12, 80);
  const std::vector<PointsX3> keys = {mesh.points, Bent(mesh.points, 2, 270 * kDegree),
                                      Bent(mesh.points, 2, 540 * kDegree)};
  const Schedule schedule = ScheduleOf(At({0, 1, 2}));
  KeySource source(keys, mesh.faces, schedule, PlainRules(schedule, true));
  for (const auto& [span, way, angle] : {std::tuple{0, 0.5, 135.0}, std::tuple{1, 0.5, 405.0}}) {
    const PointsX3 frame = source.At(span, {way})[0].points,
                   truth = Bent(mesh.points, 2, angle * kDegree);
    const PointsX3 fitted = Transformed(FitSimilarity(frame, truth, {}, false), frame);
    EXPECT_LT((fitted - truth).rowwise().norm().mean() / BoundingDiagonal(truth), 5e-3);
  }
  EXPECT_LT(source.report().largest_remainder, 0.3);
}

TEST(KeySource, APoseThatComesTwiceStandsStillBetween) {
  const Poses p;
  const Schedule schedule = ScheduleOf(At({0, 1, 2, 3}));
  KeySource source({p.a, p.b, p.b, p.c}, p.mesh.faces, schedule, PlainRules(schedule, true));
  EXPECT_LT(Gap(source.At(1, {0.4})[0].points, p.b), 1e-12);
}

TEST(KeySource, VolumeFollowsItsPathThroughAllKeys) {
  const Poses p;
  const Shown shown =
      Play({p.a, p.b, p.c, 1.1 * p.a}, p.mesh.faces, ScheduleOf(At({0, 0.5, 1.2, 2})));
  for (const SegmentDistortion& s : shown.distortion.segments) {
    EXPECT_LT(s.volume.path_deviation, 1e-8);
    EXPECT_LT(s.area.path_deviation, 0.01);
    EXPECT_GT(s.in_betweens, 0);
  }
  EXPECT_NEAR(shown.distortion.frames.back().volume, 1.331, 1e-9);
}

TEST(KeySource, SqueezesWhereTheTimelineSaysSo) {
  const Poses p;
  Timeline timeline = At({0, 1, 2});
  timeline.volume = {{0.5, 0.8}};
  const Schedule schedule = ScheduleOf(timeline);
  const Shown shown = Play(p.all(), p.mesh.faces, schedule, RulesOf(timeline, schedule, p.mesh));
  const FrameDistortion& squeezed = shown.distortion.frames[5];
  EXPECT_NEAR(squeezed.volume / squeezed.volume_path, 0.8, 1e-8);
  EXPECT_EQ(shown.points[10], p.b);
}

TEST(KeySource, PinnedVerticesStayWhereTheKeysHaveThem) {
  Poses p;
  Timeline timeline = At({0, 1, 2});
  // The foot of the tube is fixed in the first two poses, and moves in the third.
  TimelineRegion foot;
  foot.name = "foot";
  foot.center.setZero();
  foot.radius = 0.2;
  timeline.regions = {foot};
  timeline.pins = {{"foot", 0.0, 1.0}};
  const Schedule schedule = ScheduleOf(timeline);
  const Rules rules = RulesOf(timeline, schedule, p.mesh);
  p.b = Bent(p.mesh.points, 2, 1e-3);
  for (Eigen::Index i = 0; i < p.b.rows(); ++i)
    if (p.a(i, 2) > 0.25)
      p.b.row(i) << p.a(i, 0) + 0.3 * std::pow(p.a(i, 2) - 0.25, 2), p.a(i, 1), p.a(i, 2);
    else
      p.b.row(i) = p.a.row(i);
  const Shown shown = Play(p.all(), p.mesh.faces, schedule, rules);
  ASSERT_GT(rules.held[0].vertices.size(), 10u);
  for (const int v : rules.held[0].vertices)
    for (int f = 0; f <= 10; ++f) EXPECT_LT((shown.points[f].row(v) - p.a.row(v)).norm(), 1e-11);
  EXPECT_GT(
      (shown.points[15].row(rules.held[0].vertices[0]) - p.a.row(rules.held[0].vertices[0])).norm(),
      1e-3);
  EXPECT_LT(shown.distortion.segments[0].volume.path_deviation, 1e-8);
}

TEST(KeySource, TrajectoriesPassTheirPoints) {
  const Poses p;
  Timeline timeline = At({0, 1, 2});
  TimelineRegion tip;
  tip.name = "tip";
  tip.center << 0, 0, 2;
  tip.radius = 0.15;
  timeline.regions = {tip};
  const Eigen::Vector3d goal(0.6, 0.5, 1.6);
  timeline.trajectories = {{"tip", {{0.5, goal}}}};
  const Schedule schedule = ScheduleOf(timeline);
  const Rules rules = RulesOf(timeline, schedule, p.mesh);
  const Shown shown = Play(p.all(), p.mesh.faces, schedule, rules);
  Eigen::RowVector3d centroid = Eigen::RowVector3d::Zero();
  for (const int v : rules.held[0].vertices)
    centroid += shown.points[5].row(v) / static_cast<double>(rules.held[0].vertices.size());
  EXPECT_LT((centroid.transpose() - goal).norm(), 1e-10);
  EXPECT_EQ(shown.points[10], p.b);
}

TEST(KeySource, APropellerTurnsWholeTurnsBetweenEqualKeys) {
  // A body and a blade beside it; both keys are the same pose.
  Mesh mesh = MakeBox(1, 1, 1);
  const int n = mesh.vertex_count(), faces = mesh.face_count();
  mesh.points.conservativeResize(2 * n, 3);
  mesh.faces.conservativeResize(2 * faces, 3);
  for (int i = 0; i < n; ++i)
    mesh.points.row(n + i) << mesh.points(i, 0) * 2 - 0.5, mesh.points(i, 1) * 0.2 + 0.4,
        1.2 + 0.1 * mesh.points(i, 2);
  mesh.faces.bottomRows(faces) = mesh.faces.topRows(faces).array() + n;
  Timeline timeline = At({0, 1, 2});
  TimelineRegion blade;
  blade.name = "blade";
  for (int i = n; i < 2 * n; ++i) blade.vertices.push_back(i);
  timeline.regions = {blade};
  timeline.keys[0].turns["blade"] = {1, {0, 0, 1}};
  timeline.keys[1].turns["blade"] = {1, {0, 0, 1}};
  const Schedule schedule = ScheduleOf(timeline);
  const Shown shown = Play({mesh.points, mesh.points, mesh.points}, mesh.faces, schedule,
                           RulesOf(timeline, schedule, mesh));
  const Eigen::RowVector3d centre = mesh.points.bottomRows(n).colwise().mean();
  for (const int frame : {3, 5, 13}) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(2 * kPi * frame / 10, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const PointsX3 expected =
        ((mesh.points.bottomRows(n).rowwise() - centre) * turn.transpose()).rowwise() + centre;
    EXPECT_LT((shown.points[frame].bottomRows(n) - expected).norm(), 1e-9);
    EXPECT_LT((shown.points[frame].topRows(n) - mesh.points.topRows(n)).norm(), 1e-9);
  }
}

TEST(KeySource, NothingSinksBelowTheTable) {
  const Mesh mesh = MakeCylinder(0.12, 2, 12, 30);
  // Lying along x on the table, then bent upwards, then in the other direction: without the table
  // constraint it would sink.
  PointsX3 lying = mesh.points;
  for (Eigen::Index i = 0; i < lying.rows(); ++i)
    lying.row(i) << mesh.points(i, 2) - 1, mesh.points(i, 1), mesh.points(i, 0);
  PointsX3 turned = lying;
  turned.col(0) *= -1;
  turned.col(2) *= -1;  // half a turn about y
  for (PointsX3* pose : {&lying, &turned}) pose->col(2).array() -= pose->col(2).minCoeff();
  Timeline timeline = At({0, 1, 2});
  const Schedule schedule = ScheduleOf(timeline);
  const auto lowest = [](const Shown& shown) {
    double low = 1;
    for (const PointsX3& frame : shown.points) low = std::min(low, frame.col(2).minCoeff());
    return low;
  };
  EXPECT_LT(
      lowest(Play({lying, turned, lying}, mesh.faces, schedule, RulesOf(timeline, schedule, mesh))),
      -0.05);
  timeline.table_height = 0;
  timeline.keep_volume = false;
  const Shown without_volume =
      Play({lying, turned, lying}, mesh.faces, schedule, RulesOf(timeline, schedule, mesh));
  EXPECT_GT(lowest(without_volume), -1e-9);
  int most = 0;
  for (const FrameDistortion& f : without_volume.distortion.frames)
    most = std::max(most, f.on_table);
  EXPECT_GT(most, 0);
}

TEST(KeySource, AFaceWithoutAreaInOneKeyGoesStraightAndSmoothly) {
  Poses p;
  p.b.row(p.mesh.faces(100, 1)) = p.b.row(p.mesh.faces(100, 0));
  const Schedule schedule = ScheduleOf(At({0, 0.7, 2}));
  KeySource source(p.all(), p.mesh.faces, schedule, PlainRules(schedule, false));
  EXPECT_TRUE(source.At(0, {0.5})[0].points.allFinite());
  EXPECT_LT(Gap(source.At(1, {1e-9})[0].points, p.b), 1e-7);
  EXPECT_LT(PaceBetween(source, schedule, 0, 1, p.b).Jump(), 1e-2);
  EXPECT_GE(source.report().degenerate_faces, 1);
}

TEST(KeySource, SameBitsAtOneAndTwoThreads) {
  const Poses p;
  const Schedule schedule = ScheduleOf(At({0, 0.7, 2}));
  SetThreadCount(1);
  const Shown one = Play(p.all(), p.mesh.faces, schedule);
  SetThreadCount(2);
  const Shown two = Play(p.all(), p.mesh.faces, schedule);
  SetThreadCount(0);
  EXPECT_EQ(one.points, two.points);
}

}  // namespace keypose::interpolation::key_source_test
