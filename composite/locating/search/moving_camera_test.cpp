// Frames of a camera that moves, by the look of a textured figure and by its outlines.
#include <gtest/gtest.h>

#include <numbers>

#include "composite/locating/search/locate_shot.h"
#include "composite/locating/testing/spotted_film.h"
#include "core/numbers/rotations.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/spots.h"

namespace keypose::composite::moving_camera_test {

double TurnBetween(const Rigid3& a, const Rigid3& b) {
  return AngleOfDifference(RotationDifference(a.rotation, b.rotation)) * 180 / std::numbers::pi;
}

TEST(MovingCamera, IsNotFollowedToWhereOnlyOutlinesAgree) {
  Mesh ball = SpottedLump();
  ball.points = MakeIcosphere(4).points;  // the same outline from all sides
  SpottedFilm film(ball, Spots(), {20, 65});
  film.input.texture = &film.texture;
  const LocatedShot shot = LocateShot(film.input);
  for (int i = 0; i < 2; ++i)
    EXPECT_LT(TurnBetween(shot.frames[i].at.camera_from_mesh, film.truth[i].camera_from_world), 1)
        << "frame " << i;
}

TEST(MovingCamera, AllFramesAreAsExactAsThoseThatTheLensWasSolvedFrom) {
  std::vector<double> azimuths;
  for (int i = 0; i < 9; ++i) azimuths.push_back(12 * i);
  SpottedFilm film(SpottedLump(), Spots(), azimuths);
  film.input.texture = &film.texture;
  const LocatedShot shot = LocateShot(film.input);
  for (int i = 0; i < 9; ++i)
    EXPECT_LT(TurnBetween(shot.frames[i].at.camera_from_mesh, film.truth[i].camera_from_world), 0.2)
        << "frame " << i;
}

}  // namespace keypose::composite::moving_camera_test
