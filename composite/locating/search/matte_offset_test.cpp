// The lens of a shot whose mattes err alike in all frames.
#include <gtest/gtest.h>

#include <cmath>

#include "composite/locating/search/locate_shot.h"
#include "composite/locating/testing/spotted_film.h"
#include "core/testing/spots.h"

namespace keypose::composite::matte_offset_test {

/// The matte with all that lies within `px` of it.
Image8 Grown(const Image8& matte, int px) {
  Image8 grown = matte;
  for (int y = px; y < matte.height - px; ++y)
    for (int x = px; x < matte.width - px; ++x)
      for (int v = -px; v <= px; ++v)
        for (int u = -px; u <= px; ++u)
          if (u * u + v * v <= px * px && *matte.at(x + u, y + v) > 127) *grown.at(x, y) = 255;
  return grown;
}

TEST(MatteOffset, MattesThatAreTooWideAllRoundDoNotChangeTheLens) {
  SpottedFilm film(SpottedLump(), Spots(), {0, 50, 100, 150, 200, 250});
  film.input.texture = &film.texture;
  const double focal = film.input.camera.fx;
  film.input.camera.fx = film.input.camera.fy = 1.02 * focal;
  film.input.focal_fixed = false, film.input.focal_deviation = 0.05;
  for (LocateFrame& frame : film.input.frames) frame.matte = Grown(frame.matte, 2);
  const LocatedShot shot = LocateShot(film.input);
  EXPECT_NEAR(shot.matte_offset_px, 2, 0.5);
  EXPECT_NEAR(shot.camera.fx / focal, 1, 0.005);
  EXPECT_LT(std::abs(std::log(shot.camera.fx / focal)), 2 * shot.focal_deviation);
}

}  // namespace keypose::composite::matte_offset_test
