#include "texture/bake/view_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "texture/bake/testing_spheres.h"

namespace keypose::texture::view_alignment_test {

TEST(AlignPhotographs, HalvesWhatACameraIsOff) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> truth = AllRound(240);
  const std::vector<Photograph>& photographs = SharedPhotographs(true);
  std::vector<View> off = truth;
  off[5].camera.cx += 2;
  off[9].camera.cy -= 1.5;
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<BakeView> views;
  for (std::size_t v = 0; v < off.size(); ++v)
    views.emplace_back(off[v], photographs[v], mesh, scene, BakeViewOptions());
  std::vector<char> used(views.size(), 1);
  used[3] = 0;
  const std::vector<Warp> warps = AlignPhotographs(mesh, views, used);
  EXPECT_EQ(warps[3].wide, 0);
  for (std::size_t v = 0; v < off.size(); ++v) {
    if (v == 3) continue;
    const Eigen::Vector2d middle(160, 120), moved = warps[v].Moved(middle) - middle;
    const Eigen::Vector2d expected(truth[v].camera.cx - off[v].camera.cx,
                                   truth[v].camera.cy - off[v].camera.cy);
    // Some five views see a point, so a part of one view's displacement is attributed to the
    // others: it is reduced to about half, and no other view moves far.
    EXPECT_LT((moved - expected).norm(), expected.norm() > 0 ? 0.6 * expected.norm() : 0.7)
        << "view " << v << ": " << moved.transpose();
  }
}

}  // namespace keypose::texture::view_alignment_test
