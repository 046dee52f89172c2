// Keys whose vertices are doubled along the seams of their texture coordinates.
#include "interpolate/closed_seams.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>
#include <vector>

#include "core/values/size_of.h"
#include "interpolate/sequence.h"
#include "interpolate/testing/played_poses.h"

namespace keypose::interpolation::closed_seams_test {

/// A tube cut into four charts, each with vertices of its own.
struct CutTube {
  Poses poses;
  FacesX3 faces = poses.mesh.faces;
  std::vector<int> origin;  // vertex of the whole tube
  CutTube() {
    std::map<std::pair<int, int>, int> own;  // chart and vertex -> vertex
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      const Eigen::RowVector3d middle =
          (poses.mesh.points.row(faces(f, 0)) + poses.mesh.points.row(faces(f, 1)) +
           poses.mesh.points.row(faces(f, 2))) /
          3;
      const int chart = (middle.x() > 0) + 2 * (middle.z() > 1);
      for (int k = 0; k < 3; ++k) {
        const auto [at, is_new] = own.try_emplace({chart, faces(f, k)}, SizeOf(origin));
        if (is_new) origin.push_back(faces(f, k));
        faces(f, k) = at->second;
      }
    }
  }
  /// Two vertices at one place.
  std::pair<int, int> Double() const {
    for (int v = 0;; ++v)
      for (int w = 0; w < v; ++w)
        if (origin[w] == origin[v]) return {w, v};
  }
  PointsX3 Cut(const PointsX3& whole) const { return whole(origin, Eigen::all); }
};

TEST(ClosedSeams, ATubeThatIsCutForItsTextureMovesAsTheWholeOne) {
  const CutTube cut;
  const std::vector<PointsX3> whole = cut.poses.all();
  std::vector<PointsX3> keys;
  for (const PointsX3& key : whole) keys.push_back(cut.Cut(key));
  const ClosedSeams seams(keys, cut.faces);
  EXPECT_EQ(seams.joined(), SizeOf(cut.origin) - cut.poses.mesh.vertex_count());
  const Schedule schedule = MakeSchedule({3, 3});
  const Shown expected = Play(whole, cut.poses.mesh.faces, schedule),
              shown = Play(seams.Closed(keys), seams.faces(), schedule);
  ASSERT_EQ(shown.points.size(), expected.points.size());
  for (std::size_t f = 0; f < shown.points.size(); ++f)
    EXPECT_LT(Gap(seams.Opened(shown.points[f]), cut.Cut(expected.points[f])), 1e-9) << f;
  // Without them the charts part.
  const Shown parted = Play(keys, cut.faces, schedule);
  EXPECT_GT(Gap(parted.points[2], cut.Cut(expected.points[2])), 1e-3);
}

TEST(ClosedSeams, KeysWithoutSeamsKeepTheirBits) {
  const Poses poses;
  const std::vector<PointsX3> keys = poses.all();
  const ClosedSeams seams(keys, poses.mesh.faces);
  EXPECT_EQ(seams.joined(), 0);
  EXPECT_EQ(seams.faces(), poses.mesh.faces);
  EXPECT_EQ(seams.Closed(keys), keys);
  EXPECT_EQ(seams.Opened(keys[1]), keys[1]);
}

TEST(ClosedSeams, WhatOpensInAnotherKeyIsNoSeam) {
  const CutTube cut;
  std::vector<PointsX3> keys = {cut.Cut(cut.poses.mesh.points), cut.Cut(cut.poses.b)};
  const int all = ClosedSeams(keys, cut.faces).joined();
  keys[1].row(cut.Double().second) += Eigen::RowVector3d(0.1, 0, 0);
  EXPECT_EQ(ClosedSeams(keys, cut.faces).joined(), all - 1);
}

TEST(ClosedSeams, RegionsHoldTheJoinedVertexOnce) {
  const CutTube cut;
  const std::vector<PointsX3> keys = {cut.Cut(cut.poses.mesh.points)};
  const ClosedSeams seams(keys, cut.faces);
  const auto [first, last] = cut.Double();
  Rules rules;
  rules.held.push_back({"foot", {first, last}, true, {1}, {}});
  const std::vector<int> held = seams.Closed(rules).held[0].vertices;
  ASSERT_EQ(held.size(), 1u);
  EXPECT_EQ(seams.Closed(keys)[0].row(held[0]), keys[0].row(last));
}

}  // namespace keypose::interpolation::closed_seams_test
