// A figure and photographs of it from unknown sides.
#pragma once

#include <gtest/gtest.h>

#include "core/pictures/fit_view.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "fit/testing/spotted_lump.h"

namespace keypose::fit {

class CamerasAround : public ::testing::Test {
 protected:
  /// From beside all directions that are tried.
  PreparedView Photograph(double azimuth, double elevation) const {
    const Camera lens = RingAround(mesh_, {0})[0].camera;
    return PhotographOf(
        mesh_, texture_,
        keypose::FitView(mesh_.points, azimuth, elevation, lens.width, lens.height));
  }
  static double Off(const Rigid3& camera, const PreparedView& view) {
    return (camera.Inverse().translation - view.Center()).norm() / view.Center().norm();
  }

  Mesh mesh_ = SpottedLump();
  Image8 texture_ = Spots();
};

}  // namespace keypose::fit
