// Films that an encoder scaled, cut, framed or turned, against the pixels where points must lie.
#include "views/shot/view_for_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "core/pictures/fit_view.h"
#include "core/values/errors.h"

namespace keypose::filmed_view_test {

using Eigen::Vector2d;
using ::testing::HasSubstr;

View Calibrated(int width = 1088, int height = 1920) {
  View view;
  view.name = "cam1";
  view.camera = {width, height, 1681, 1679, width / 2.0 - 12, height / 2.0 + 9,
                 -0.05, 0.13,   6e-4, -7e-4};
  view.camera_from_world = LookAt({2.1, -3.2, 1.9}, {0, 0, 0.9});
  return view;
}

/// A grey picture with black rows at top and bottom, and black columns at both sides.
Image8 Framed(int width, int height, int rows, int columns) {
  Image8 picture(width, height, 3, 4);
  for (int y = rows; y < height - rows; ++y)
    for (int x = columns; x < width - columns; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = 90;
  return picture;
}

/// Largest distance between a point in the film's view and its calibrated pixel, moved as the
/// encoder moved it.
double Apart(const View& film, const View& calibrated,
             const std::function<Vector2d(const Vector2d&)>& moved) {
  double most = 0;
  for (const double x : {-0.4, 0.0, 0.4})
    for (const double z : {0.1, 0.9, 1.7}) {
      const Eigen::Vector3d point(x, 0.2, z);
      most = std::max(most, (film.Project(point) - moved(calibrated.Project(point))).norm());
    }
  return most;
}

TEST(ViewForPictures, SameSizeIsTheSameViewAndNothingIsSaid) {
  const AdjustedView film = ViewForPictures(Calibrated(), Framed(1088, 1920, 0, 0), {}, "track");
  EXPECT_EQ(film.note, "");
  EXPECT_EQ(Apart(film.view, Calibrated(), [](const Vector2d& p) { return p; }), 0);
}

TEST(ViewForPictures, HalfTheSizeIsScaledAndSaid) {
  const AdjustedView film = ViewForPictures(Calibrated(), Framed(544, 960, 0, 0), {}, "track");
  EXPECT_LT(Apart(film.view, Calibrated(), [](const Vector2d& p) { return Vector2d(p / 2); }),
            1e-9);
  EXPECT_THAT(film.note, HasSubstr("the film of camera cam1 has 544 x 960 pixels"));
  EXPECT_THAT(film.note, HasSubstr("1088 x 1920: scaled by 0.5"));
}

TEST(ViewForPictures, BlackBordersSayThatThePictureWasScaledBetweenThem) {
  const AdjustedView film = ViewForPictures(Calibrated(), Framed(1080, 1920, 7, 0), {}, "track");
  const auto moved = [](const Vector2d& p) {
    return Vector2d(p.x() * 1080 / 1088, p.y() * 1906 / 1920 + 7);
  };
  EXPECT_LT(Apart(film.view, Calibrated(), moved), 1e-9);
  EXPECT_THAT(film.note, HasSubstr("between black borders of 7 and 7 pixels at top and bottom"));
  // 4:3 in 16:9
  const View wide = Calibrated(1440, 1080);
  EXPECT_LT(Apart(ViewForPictures(wide, Framed(1920, 1080, 0, 240), {}, "track").view, wide,
                  [](const Vector2d& p) { return Vector2d(p.x() + 240, p.y()); }),
            1e-9);
}

TEST(ViewForPictures, WithoutBordersWhatIsMissingIsTakenAtTheRightAndAtTheBottom) {
  const auto same = [](const Vector2d& p) { return p; };
  const AdjustedView film = ViewForPictures(Calibrated(), Framed(1080, 1920, 0, 0), {}, "track");
  EXPECT_LT(Apart(film.view, Calibrated(), same), 1e-9);
  EXPECT_EQ(film.view.camera.width, 1080);
  EXPECT_THAT(film.note, HasSubstr("8 pixels at the right taken as cut off"));
  const AdjustedView both = ViewForPictures(Calibrated(), Framed(1080, 1912, 0, 0), {}, "track");
  EXPECT_LT(Apart(both.view, Calibrated(), same), 1e-9);
  EXPECT_THAT(both.note, HasSubstr("8 pixels at the right and 8 pixels at the bottom"));
  const AdjustedView half = ViewForPictures(Calibrated(), Framed(540, 960, 0, 0), {}, "track");
  EXPECT_LT(Apart(half.view, Calibrated(), [](const Vector2d& p) { return Vector2d(p / 2); }),
            1e-9);
  EXPECT_THAT(half.note, HasSubstr("scaled by 0.5, 4 pixels at the right"));
}

TEST(ViewForPictures, ADarkSceneIsNotTakenForABorder) {
  // the upper 300 rows of the film are dark, as a ceiling may be; below there is no border
  Image8 picture = Framed(1080, 1920, 0, 0);
  std::fill(picture.data.begin(), picture.data.begin() + 300 * 1080 * 3, std::uint8_t{6});
  EXPECT_THAT(ViewForPictures(Calibrated(), picture, {}, "track").note, HasSubstr("cut off"));
}

TEST(ViewForPictures, TurnedFilmsAreTurnedTheWayThatBringsUpToTheTop) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const View upright = Calibrated();
  for (const int quarters : {1, 3}) {  // how the camera hangs
    View hung = upright;
    for (int i = 0; i < quarters; ++i) hung = TurnedClockwise(hung);
    // its pixels are those of the upright picture, turned
    const auto clockwise = [&](const Vector2d& p) { return Vector2d(1920 - p.y(), p.x()); };
    const auto anticlockwise = [&](const Vector2d& p) { return Vector2d(p.y(), 1088 - p.x()); };
    if (quarters == 1)
      EXPECT_LT(Apart(hung, upright, clockwise), 1e-9);
    else
      EXPECT_LT(Apart(hung, upright, anticlockwise), 1e-9);
    const AdjustedView film = ViewForPictures(hung, Framed(1088, 1920, 0, 0), up, "track");
    EXPECT_LT(Apart(film.view, upright, [](const Vector2d& p) { return p; }), 1e-9);
    EXPECT_THAT(film.note, HasSubstr(quarters == 1 ? "turned anticlockwise" : "turned clockwise"));
    // turned and scaled between borders as well
    const AdjustedView framed = ViewForPictures(hung, Framed(1080, 1920, 7, 0), up, "track");
    EXPECT_THAT(framed.note, HasSubstr("borders of 7 and 7"));
    EXPECT_THAT(framed.note, HasSubstr("after a quarter turn"));
    EXPECT_THROW(ViewForPictures(hung, Framed(1088, 1920, 0, 0), {}, "track"), InputError);
  }
}

TEST(ViewForPictures, OtherShapesAreRefusedWithBothSizesAndTheCure) {
  try {
    ViewForPictures(Calibrated(), Framed(1000, 1920, 0, 0), Eigen::Vector3d(0, 0, 1), "track");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("camera cam1 have 1000 x 1920 pixels"));
    EXPECT_THAT(error.what(), HasSubstr("calibrated with 1088 x 1920"));
    EXPECT_THAT(error.what(), HasSubstr("take them from cx and cy"));
  }
}

TEST(ViewForPictures, ACalibrationWithoutSizeTakesTheFilms) {
  View view = Calibrated();
  view.camera.width = view.camera.height = 0;
  const AdjustedView film = ViewForPictures(view, Framed(1000, 700, 0, 0), {}, "track");
  EXPECT_EQ(film.view.camera.width, 1000);
  EXPECT_EQ(film.view.camera.cx, view.camera.cx);
}

}  // namespace keypose::filmed_view_test
