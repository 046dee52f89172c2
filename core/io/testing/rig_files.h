// Calibrations of camera rigs as files.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/testing/folder.h"
#include "core/values/camera.h"

namespace keypose {

class RigTest : public ::testing::Test, public TestingFolder {
 protected:
  static std::vector<View> Ring() {
    std::vector<View> views;
    for (int i = 0; i < 4; ++i) {
      View view;
      view.name = "cam" + std::to_string(i + 1);
      view.camera = {1000, 800, 900, 901, 510.25, 395.5, 0.01, -0.02, 0.001, 0.002};
      const double a = 1.5 * i;
      view.camera_from_world = LookAt({4 * std::cos(a), 4 * std::sin(a), 1.5}, {0, 0, 0.9});
      views.push_back(view);
    }
    return views;
  }
  static void ExpectSame(const std::vector<View>& a, const std::vector<View>& b, double lens_px) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].name, b[i].name);
      const Eigen::Vector3d x(0.3, -0.4, 1.1);
      EXPECT_LT((a[i].Project(x) - b[i].Project(x)).norm(), lens_px) << i;
      EXPECT_LT((a[i].Center() - b[i].Center()).norm(), 1e-6) << i;
    }
  }
};

}  // namespace keypose
