#include "fit/cameras/views_around.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/surfaces/ray_scene.h"
#include "fit/cameras/testing/photographed_figure.h"

namespace keypose::fit::views_around_test {

TEST_F(CamerasAround, OneOfTheMostAlikeIsNearTheTrueOne) {
  const RayScene scene(mesh_.points, mesh_.faces);
  for (const double azimuth : {8.0, 113.0, 262.0}) {
    const PreparedView view = Photograph(azimuth, 34);
    double nearest = 1;
    for (const ViewAround& around : ViewsAround(mesh_, texture_, scene, view, 6)) {
      nearest = std::min(nearest, Off(around.camera_from_world, view));
      EXPECT_GT(around.overlap, 0.8);
    }
    EXPECT_LT(nearest, 0.3) << azimuth;  // directions are 15 and 20 degrees apart
  }
}

TEST_F(CamerasAround, ALikelyPlaceOfTheMaskIsKept) {
  const RayScene scene(mesh_.points, mesh_.faces);
  const PreparedView view = Photograph(8, 25);
  EXPECT_GT(ViewsAround(mesh_, {}, scene, view, 1).at(0).overlap, 0.95);
}

}  // namespace keypose::fit::views_around_test
