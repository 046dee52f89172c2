// Narrow holes in a flat figure in front of a grey backdrop, with known truth for every pixel.
#include "capture/segmentation/mask_holes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "capture/segmentation/trimap.h"

namespace keypose::capture::mask_holes_test {

constexpr int kWidth = 240, kHeight = 180;
constexpr std::array<std::uint8_t, 3> kGrey{176, 176, 178}, kTeal{40, 130, 120};

bool OnFigure(int x, int y) { return x >= 60 && x < 180 && y >= 30 && y < 150; }
/// A notch that narrows from seven pixels at the figure's side to its tip 30 pixels inside.
bool InNotch(int x, int y) { return x >= 60 && x < 90 && std::abs(y - 90) <= 3.5 * (90 - x) / 30; }
bool InHole(int x, int y) { return std::hypot(x - 150, y - 60) < 4; }

struct Photo {
  Image8 image, mask;  // the mask is filled
  Backdrop backdrop;
};

Photo MakePhoto(const std::function<bool(int, int)>& hole, double light = 1, int thickness = 2) {
  Photo photo{Image8(kWidth, kHeight, 3), Image8(kWidth, kHeight, 1, 0), {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool open = OnFigure(x, y) && hole(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        photo.image.at(x, y)[c] = OnFigure(x, y) && !open
                                      ? kTeal[c]
                                      : static_cast<std::uint8_t>((open ? light : 1) * kGrey[c]);
      *photo.mask.at(x, y) = OnFigure(x, y) ? 255 : 0;
    }
  Image8 empty(kWidth / 2, kHeight / 2, 3);
  for (std::size_t i = 0; i < empty.data.size(); ++i) empty.data[i] = kGrey[i % 3];
  photo.backdrop = {LabOf(empty),
                    {2, 2, 2},
                    Image8(kWidth / 2, kHeight / 2, 1, static_cast<std::uint8_t>(thickness))};
  return photo;
}

struct Opened {
  int right = 0, wrong = 0, hole = 0;  // pixels
};

Opened Open(const Photo& photo, const std::function<bool(int, int)>& hole) {
  Image8 mask = photo.mask;
  OpenMaskHoles(photo.image, photo.backdrop, mask);
  Opened opened;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (!OnFigure(x, y)) continue;
      const bool open = *mask.at(x, y) == 0;
      opened.hole += hole(x, y), opened.right += open && hole(x, y),
          opened.wrong += open && !hole(x, y);
    }
  return opened;
}

TEST(OpenMaskHoles, OpensNotchesAndHolesToTheirRims) {
  for (const auto& hole : {InNotch, InHole}) {
    const Opened opened = Open(MakePhoto(hole), hole);
    EXPECT_GT(opened.right, 0.95 * opened.hole);
    EXPECT_LT(opened.wrong, 140);  // a pixel all round
  }
}

TEST(OpenMaskHoles, OpensHolesInTheFiguresShadeButNotDarkOnes) {
  const Opened shaded = Open(MakePhoto(InHole, 0.93), InHole);
  EXPECT_EQ(shaded.right, shaded.hole);
  EXPECT_EQ(Open(MakePhoto(InHole, 0.6), InHole).right, 0);
}

TEST(OpenMaskHoles, LeavesWhatLiesBeforeAThickHull) {
  EXPECT_EQ(Open(MakePhoto(InHole, 1, 25), InHole).right, 0);
}

TEST(OpenMaskHoles, LeavesWhatIsTooLargeOrNothingIsKnownOf) {
  const auto large = [](int x, int y) { return std::hypot(x - 120, y - 90) < 40; };
  EXPECT_EQ(Open(MakePhoto(large), large).right, 0);
  Photo photo = MakePhoto(InHole);
  photo.backdrop.empty = {};
  EXPECT_EQ(Open(photo, InHole).right, 0);
}

// White clay in its own shadow is as grey as the backdrop in one place, but the shadow has a smooth
// end on one side.
TEST(OpenMaskHoles, LeavesShadeThatEndsSmoothly) {
  for (const double step :
       {6.0, 40.0}) {  // grey levels per pixel: a shadow, and an edge as sharp as a hole's
    Photo photo = MakePhoto([](int, int) { return false; });
    const auto shade = [](int x, int y) { return std::hypot(x - 120, y - 90) < 4; };
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (OnFigure(x, y))
          for (std::size_t c = 0; c < 3; ++c)
            photo.image.at(x, y)[c] = static_cast<std::uint8_t>(
                std::min(250.0, kGrey[c] + step * std::max(0.0, std::hypot(x - 120, y - 90) - 4)));
    EXPECT_EQ(Open(photo, shade).right > 0, step > 10) << step;
  }
}

// White in its own shadow beside a black pupil and a lid, as an eye seen from the side: sharp edges
// to these, but a smooth end on its open side.
TEST(OpenMaskHoles, LeavesAnEyesShadeBesideItsPupil) {
  const auto shade = [](int x, int y) {
    return x < 121 && y > 88 && std::hypot(x - 120, y - 90) < 8;
  };
  for (const double step : {6.0, 40.0}) {
    Photo photo = MakePhoto([](int, int) { return false; });
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (!OnFigure(x, y)) continue;
        const bool dark = x >= 121 || y <= 88;
        const double light = step * std::max(0.0, std::hypot(x - 120, y - 90) - 8);
        for (std::size_t c = 0; c < 3; ++c)
          photo.image.at(x, y)[c] =
              dark ? 20 : static_cast<std::uint8_t>(std::min(250.0, kGrey[c] + light));
      }
    EXPECT_EQ(Open(photo, shade).right > 0, step > 10) << step;
  }
}

// A strip along the outline with the backdrop's colour is no hole: the figure is on one side of it
// only.
TEST(OpenMaskHoles, LeavesStripsAlongTheOutline) {
  const auto strip = [](int x, int y) { return x < 64 && y > 70 && y < 100; };
  EXPECT_EQ(Open(MakePhoto(strip), strip).right, 0);
}

TEST(BackdropsOf, TellNothingOfAFigureOfTheirOwnColours) {
  for (const bool grey_figure : {false, true}) {
    std::vector<Image8> lab, trimaps;
    for (int i = 0; i < 6; ++i) {
      const Photo photo = MakePhoto(
          [&](int x, int y) { return grey_figure && x > 100 && x < 140 && y > 60 && y < 100 + i; });
      lab.push_back(LabOf(photo.image));
      Image8 trimap(kWidth, kHeight, 1, kBackground);
      for (std::size_t p = 0; p < trimap.data.size(); ++p)
        if (photo.mask.data[p]) trimap.data[p] = kObject;
      trimaps.push_back(trimap);
    }
    EXPECT_EQ(BackdropsOf(lab, trimaps, {{{0, 1, 2, 3, 4, 5}}}, 6).Confusing(), grey_figure);
  }
}

}  // namespace keypose::capture::mask_holes_test
