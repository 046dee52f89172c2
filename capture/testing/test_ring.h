// A ring of photographs of a ball with an exact outline, with masks that are wrong in places.
#pragma once

#include <cstddef>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

constexpr int kRingWidth = 200, kRingHeight = 150, kRingViews = 18;
// The ball at the origin is a disc of 39 px radius in the pictures.
constexpr double kRingFocal = 220, kRingDistance = 4, kBallRadius = 0.7;

struct TestRing {
  std::vector<View> views;
  std::vector<Image8> images, truths, masks;
};

/// Views 3 and 4 have a lamp beside the ball in photograph and mask; view 9 lacks the ball's dark
/// part in both.
TestRing MakeTestRing();

/// Draws the ring's view i with the ball at another position or of another size [px].
void Redraw(TestRing& ring, std::size_t i, double dx, double dy, double radius);

/// In view i, divides the ball's colours by `divisor` left of `from` px before its middle, like an
/// underside in front of a dark set, and removes that part from its mask.
void Darken(TestRing& ring, std::size_t i, int from, double divisor);

/// Intersection over union of two masks.
double Iou(const Image8& a, const Image8& b);

}  // namespace keypose::capture
