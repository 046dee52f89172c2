// Photographs for the tests of this room: a speckled ellipse that turns in front of an uneven wall.
#pragma once

#include <filesystem>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct TestPhoto {
  Image8 image, truth;  ///< RGB; 255 where the ellipse is
};

enum class TestWall { kLight, kDark };

/// Photograph `index` of a set; sizes may differ between calls.
TestPhoto MakeTestPhoto(int index, int width, int height, TestWall wall);
/// The same view of a figure of other colours: red and blue exchanged.
Image8 MakeTestStranger(int index, int width, int height, TestWall wall);
/// The wall alone.
Image8 MakeTestWall(int width, int height, TestWall wall);
/// Camera `i` of `count` around the origin, at `distance`, directed at it; `rise` is its height
/// before the direction is normalised.
View MakeTestView(int i, int count, double distance, double rise, int width, int height,
                  double focal_px);
/// Box blur of 2 radius + 1 pixels, three times over.
Image8 Blurred(const Image8& image, int radius);

}  // namespace keypose::capture
