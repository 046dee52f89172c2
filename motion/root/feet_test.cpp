#include "motion/root/feet.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"

namespace keypose::motion::feet_test {

/// Two long feet under a body, as separate boxes.
Mesh MakeFeet() {
  Mesh mesh;
  for (double x : {-0.2, 0.2}) {
    const Mesh foot = MakeCylinder(0.05, 0.3, 8, 12);  // lies along y
    const int before = mesh.vertex_count(), faces = mesh.face_count();
    mesh.points.conservativeResize(before + foot.vertex_count(), 3);
    for (int i = 0; i < foot.vertex_count(); ++i)
      mesh.points.row(before + i) << x + foot.points(i, 0), foot.points(i, 2),
          0.02 * foot.points(i, 1);
    mesh.faces.conservativeResize(faces + foot.face_count(), 3);
    mesh.faces.bottomRows(foot.face_count()) = foot.faces.array() + before;
  }
  const Mesh body = MakeIcosphere(2);
  const int before = mesh.vertex_count(), faces = mesh.face_count();
  mesh.points.conservativeResize(before + body.vertex_count(), 3);
  mesh.points.bottomRows(body.vertex_count()) =
      (0.4 * body.points).rowwise() + Eigen::RowVector3d(0, 0, 1);
  mesh.faces.conservativeResize(faces + body.face_count(), 3);
  mesh.faces.bottomRows(body.face_count()) = body.faces.array() + before;
  return mesh;
}

TEST(FindSoles, HeelAndToeOfEachFoot) {
  const Mesh mesh = MakeFeet();
  const std::vector<SolePatch> soles = FindSoles(mesh.points, mesh.faces);
  ASSERT_EQ(soles.size(), 4u);
  for (const SolePatch& sole : soles) {
    EXPECT_NEAR(std::abs(sole.centre[0]), 0.2, 0.02);
    EXPECT_NEAR(std::abs(sole.centre[1] - 0.15), 0.08, 0.03);
  }
  const auto pairs = PairSoles(
      soles, soles, [](const Eigen::RowVector3d& p) { return p; }, 1.4);
  EXPECT_EQ(pairs, (std::vector<int>{0, 1, 2, 3}));
}

TEST(FindContacts, LowAndSlowFramesWithoutGaps) {
  SoleTrack track{PointsX3::Zero(60, 3), Eigen::VectorXd::Zero(60)};
  for (int t = 0; t < 60; ++t) {
    const bool swings = t >= 20 && t < 40;
    if (t > 0) track.centres.row(t) = track.centres.row(t - 1);
    if (swings) track.centres(t, 0) += 0.1, track.lowest[t] = 0.2;
  }
  track.lowest[10] = 0.2;  // a flicker
  const std::vector<char> stands = FindContacts(track, 1.8, 24);
  for (int t = 0; t < 60; ++t) EXPECT_EQ(stands[t], t < 19 || t >= 40) << t;
}

/// A walk whose feet slide: the body moves by `pace` a frame, but steps are `step` a frame.
std::vector<SoleTrack> SlidingWalk(double slide, std::vector<std::vector<char>>& contacts) {
  std::vector<SoleTrack> tracks(2, {PointsX3::Zero(80, 3), Eigen::VectorXd::Zero(80)});
  contacts.assign(2, std::vector<char>(80, 0));
  for (int t = 1; t < 80; ++t)
    for (int foot = 0; foot < 2; ++foot) {
      const bool stands = (t / 20) % 2 == foot;
      tracks[foot].centres.row(t) = tracks[foot].centres.row(t - 1);
      tracks[foot].centres(t, 0) += stands ? slide : 0.1 + slide;
      tracks[foot].centres(t, 2) = stands ? 0.05 : 0.15;
      contacts[foot][t] = stands;
    }
  return tracks;
}

TEST(PlanFeet, FeetThatStandDoNotSlide) {
  std::vector<std::vector<char>> contacts;
  const std::vector<SoleTrack> tracks = SlidingWalk(0.02, contacts);
  const FootPlan plan = PlanFeet(tracks, contacts, {0.03, 0.03});
  for (int foot = 0; foot < 2; ++foot)
    for (int t = 1; t < 80; ++t) {
      if (!contacts[foot][t] || !contacts[foot][t - 1]) continue;
      const auto at = [&](int k) -> Eigen::RowVector3d {
        return tracks[foot].centres.row(k) + plan.shift.row(k) + plan.holds[foot].moves.row(k);
      };
      EXPECT_LT((at(t) - at(t - 1)).norm(), 1e-12);
      EXPECT_NEAR(at(t)[2], 0.03, 1e-12);
      EXPECT_EQ(plan.holds[foot].firmness[t], 1);
      // The body takes nearly all of it, so that the legs need hardly any stretch.
      EXPECT_LT(plan.holds[foot].moves.row(t).norm(), 0.1);
    }
}

}  // namespace keypose::motion::feet_test
