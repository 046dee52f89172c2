#include "composite/light/plate_exposure.h"

#include <gtest/gtest.h>

namespace keypose::composite::plate_exposure_test {

TEST(Exposure, WhatMovedDoesNotCount) {
  ImageF plate(90, 60, 3, 0.3f), picture = plate;
  const float factors[3] = {1.2f, 1.0f, 0.8f};
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 90; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = x < 25 ? 0.7f : factors[c] * plate.at(x, y)[c];
  const Eigen::Vector3d found = ExposureOf(picture, plate, {});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], factors[c], 1e-5);
  const Image8 everywhere(90, 60, 1, 255);
  EXPECT_EQ(ExposureOf(picture, plate, everywhere), Eigen::Vector3d::Ones());
}

}  // namespace keypose::composite::plate_exposure_test
