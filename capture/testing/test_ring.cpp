#include "capture/testing/test_ring.h"

#include <algorithm>
#include <cmath>

#include "capture/testing/test_images.h"

namespace keypose::capture {
namespace {

View RingView(int i) {
  return MakeTestView(i, kRingViews, kRingDistance, i % 2 ? 1.2 : 0.3, kRingWidth, kRingHeight,
                      kRingFocal);
}

bool OnBall(int x, int y) {
  const double sine = kBallRadius / kRingDistance,
               reach = kRingFocal * sine / std::sqrt(1 - sine * sine);
  return std::hypot(x + 0.5 - kRingWidth / 2.0, y + 0.5 - kRingHeight / 2.0) < reach;
}

/// An object of the ball's colours that only some photographs show, touching the ball.
bool OnLamp(int x, int y) {
  return x > kRingWidth / 2 + 34 && x < kRingWidth / 2 + 64 && std::abs(y - kRingHeight / 2) < 9;
}
/// A part of the ball that is nearly as dark as the wall in one photograph.
bool OnDark(int x, int y) {
  return OnBall(x, y) && x < kRingWidth / 2 - 10 && y > kRingHeight / 2 + 10;
}

}  // namespace

TestRing MakeTestRing() {
  TestRing ring;
  const Image8 wall = MakeTestWall(kRingWidth, kRingHeight, TestWall::kDark);
  const Image8 clay = MakeTestPhoto(0, 3 * kRingWidth, 3 * kRingHeight, TestWall::kDark)
                          .image;  // the middle is entirely clay
  for (int i = 0; i < kRingViews; ++i) {
    Image8 image = wall, truth(kRingWidth, kRingHeight, 1, 0), mask(kRingWidth, kRingHeight, 1, 0);
    for (int y = 0; y < kRingHeight; ++y)
      for (int x = 0; x < kRingWidth; ++x) {
        const bool lamp = (i == 3 || i == 4) && OnLamp(x, y), dark = i == 9 && OnDark(x, y),
                   ball = OnBall(x, y);
        if (ball || lamp)
          std::copy_n(
              clay.at(kRingWidth + (x + 7 * i) % 90 + 50, kRingHeight + (y + 3 * i) % 70 + 40), 3,
              image.at(x, y));
        for (int c = 0; dark && c < 3; ++c) image.at(x, y)[c] /= 3;
        *truth.at(x, y) = ball ? 255 : 0;
        *mask.at(x, y) = (ball && !dark) || lamp ? 255 : 0;
      }
    ring.views.push_back(RingView(i));
    ring.images.push_back(std::move(image));
    ring.truths.push_back(std::move(truth));
    ring.masks.push_back(std::move(mask));
  }
  return ring;
}

void Redraw(TestRing& ring, std::size_t i, double dx, double dy, double radius) {
  Image8& image = ring.images[i];
  const Image8 wall = MakeTestWall(kRingWidth, kRingHeight, TestWall::kDark);
  const Image8 clay = MakeTestPhoto(0, 3 * kRingWidth, 3 * kRingHeight, TestWall::kDark).image;
  for (int y = 0; y < kRingHeight; ++y)
    for (int x = 0; x < kRingWidth; ++x) {
      const bool on =
          std::hypot(x + 0.5 - kRingWidth / 2.0 - dx, y + 0.5 - kRingHeight / 2.0 - dy) < radius;
      std::copy_n(on ? clay.at(kRingWidth + x % 90 + 50, kRingHeight + y % 70 + 40) : wall.at(x, y),
                  3, image.at(x, y));
      *ring.masks[i].at(x, y) = *ring.truths[i].at(x, y) = on ? 255 : 0;
    }
}

void Darken(TestRing& ring, std::size_t i, int from, double divisor) {
  for (int y = 0; y < kRingHeight; ++y)
    for (int x = 0; x < kRingWidth / 2 - from; ++x) {
      if (!*ring.truths[i].at(x, y)) continue;
      for (int c = 0; c < 3; ++c) {
        std::uint8_t& level = ring.images[i].at(x, y)[c];
        level = static_cast<std::uint8_t>(level / divisor);
      }
      *ring.masks[i].at(x, y) = 0;
    }
}

double Iou(const Image8& a, const Image8& b) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    both += a.data[i] > 127 && b.data[i] > 127, either += a.data[i] > 127 || b.data[i] > 127;
  return both / either;
}

}  // namespace keypose::capture
