#include "report/shots_stage.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/pictures/fit_view.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"

namespace keypose::report::shots_stage_test {

Image8 MaskOf(const Mesh& mesh, const View& view) {
  const Raster raster = Rasterize(mesh, RayScene(mesh.points, mesh.faces), view);
  Image8 mask(view.camera.width, view.camera.height, 1);
  std::transform(raster.face.data.begin(), raster.face.data.end(), mask.data.begin(),
                 [](int face) { return static_cast<std::uint8_t>(face >= 0 ? 255 : 0); });
  return mask;
}

TEST(Shrunk, ProjectsToTheSamePlace) {
  const Mesh mesh = MakeIcosphere(3);
  Shot shot;
  shot.view = FitView(mesh.points, 0, 15, 320, 280);
  shot.photograph = Image8(320, 280, 3, 90);
  shot.mask = MaskOf(mesh, shot.view);
  const Shot half = Shrunk(shot, 0.5);
  EXPECT_EQ(half.photograph.width, 160);
  EXPECT_EQ(half.mask.height, 140);
  const Eigen::Vector3d x(0.2, 0.3, 0.4);
  EXPECT_LT((half.view.Project(x) - 0.5 * shot.view.Project(x)).norm(), 1e-9);
  const Image8 mask = MaskOf(mesh, half.view);
  int differing = 0;
  for (std::size_t p = 0; p < mask.data.size(); ++p) differing += half.mask.data[p] != mask.data[p];
  EXPECT_LT(differing, 160 + 140) << "the outline alone";
  EXPECT_EQ(Shrunk(shot, 1).photograph.data, shot.photograph.data);
}

}  // namespace keypose::report::shots_stage_test
