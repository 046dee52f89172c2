#include "report/shots_stage.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/pictures/image_io.h"
#include "core/pictures/fit_view.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"

namespace keypose::report::shots_stage_test {

Image8 MaskOf(const Mesh& mesh, const View& view) {
  return Covered(mesh, RayScene(mesh.points, mesh.faces), view);
}

/// How many pixels of the mask, read at that size, differ from what the mesh covers there.
int Differing(const View& view, int longer_px) {
  const Mesh mesh = MakeIcosphere(3);
  const TestingFolder folder;
  const Image8 mask = MaskOf(mesh, view);
  WriteImage(folder.path() / "mask.png", mask);
  WriteImage(folder.path() / "photograph.png", Image8(mask.width, mask.height, 3, 90));
  const Shot whole =
      ReadShot(view, folder.path() / "photograph.png", folder.path() / "mask.png", longer_px);
  EXPECT_EQ(whole.photograph.width, longer_px);
  EXPECT_EQ(whole.mask.height, longer_px * 280 / 320);
  const Shot shot = Cropped(whole, mesh.points);
  EXPECT_FALSE(shot.view.camera.distorted());
  const Image8 want = MaskOf(mesh, shot.view);
  int differing = 0;
  for (std::size_t p = 0; p < want.data.size(); ++p)
    differing += (shot.mask.data[p] >= 128) != (want.data[p] >= 128);
  return differing;
}

TEST(ReadShot, ShowsTheMeshWhereItsCameraDoes) {
  View view = FitView(MakeIcosphere(3).points, 0, 15, 320, 280);
  EXPECT_EQ(Differing(view, 320), 0) << "as it is";
  EXPECT_LT(Differing(view, 160), 60) << "an outline of some 400 pixels";
  view.camera.k1 = -0.3;
  view.camera.p1 = 0.004;
  EXPECT_LT(Differing(view, 320), 250) << "an outline of some 800 pixels";
  EXPECT_LT(Differing(view, 160), 60);
}

}  // namespace keypose::report::shots_stage_test
