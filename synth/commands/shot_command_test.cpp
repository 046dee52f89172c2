#include "synth/commands/shot_command.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/io/pictures/image_io.h"
#include "core/io/project/shot_io.h"
#include "core/pictures/render.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::synth::shot_command_test {

namespace fs = std::filesystem;

class SyntheticShot : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    command_.output = folder_;
    command_.world.spacing_m = 0.006;
    command_.set.width = 320, command_.set.height = 180;
    command_.shows = {{2, "rest"}, {4, "wave"}};
    command_.photographs = false, command_.clean_plate = true;
  }
  ShotCommand command_;
};

TEST_F(SyntheticShot, TruthLiesOnThePictures) {
  RunShot(command_, nullptr);
  const FilmedShot shot = ReadShot(command_.output / "truth/shot/shot.json");
  ASSERT_EQ(shot.frames.size(), 3u);
  EXPECT_EQ(shot.frames[0].pose, "rest");
  EXPECT_EQ(shot.frames[1].pose, "");
  EXPECT_EQ(shot.frames[2].pose, "wave");
  const World world = MakeWorld(command_.world);
  const Image8 plate = ReadImage(command_.output / "plate.png", 3);
  for (const ShotFrame& frame : {shot.frames[0], shot.frames[2]}) {
    Mesh posed;
    posed.points =
        Transformed(frame.world_from_character, world.PoseNamed(frame.pose)(world.rest.points));
    posed.faces = world.rest.faces;
    const View view{"", shot.camera, frame.camera_from_world};
    const Raster raster = Rasterize(posed, RayScene(posed.points, posed.faces), view);
    const Image8 matte = ReadImage(command_.output / "truth/shot/mattes" / frame.picture, 1);
    const Image8 picture = ReadImage(command_.output / "film" / frame.picture, 3);
    int covered = 0, wrong = 0, differs = 0;
    for (int y = 0; y < matte.height; ++y)
      for (int x = 0; x < matte.width; ++x) {
        const bool inside = *raster.face.at(x, y) >= 0;
        covered += inside;
        wrong += inside ? *matte.at(x, y) == 0 : *matte.at(x, y) == 255;
        int difference = 0;
        for (int c = 0; c < 3; ++c) difference += std::abs(picture.at(x, y)[c] - plate.at(x, y)[c]);
        differs += inside && difference > 12;
      }
    EXPECT_GT(covered, 1500);
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(differs, 0.85 * covered);
  }
  EXPECT_EQ(FilmPictures(command_.output / "film").size(), 3u);
  EXPECT_EQ(FilmPictures(command_.output / "truth/shot/frames").size(), 2u);
}

TEST_F(SyntheticShot, AShorterFilmInOneFolderHasNoPictureOfTheOneBefore) {
  command_.set.width = 160, command_.set.height = 90;
  RunShot(command_, nullptr);
  ASSERT_TRUE(std::filesystem::exists(command_.output / "film/0004.png"));
  command_.shows = {{2, "rest"}, {3, "wave"}};
  RunShot(command_, nullptr);
  EXPECT_TRUE(std::filesystem::exists(command_.output / "film/0003.png"));
  EXPECT_FALSE(std::filesystem::exists(command_.output / "film/0004.png"));
  EXPECT_FALSE(std::filesystem::exists(command_.output / "truth/shot/mattes/0004.png"));
}

TEST_F(SyntheticShot, KeysAloneLeaveTheirTimesOpen) {
  command_.keys_only = true, command_.clean_plate = false;
  RunShot(command_, nullptr);
  const std::vector<FilmPicture> film = FilmPictures(command_.output / "film");
  ASSERT_EQ(film.size(), 2u);
  EXPECT_EQ(film[1].frame, 2);
  EXPECT_EQ(FilmPictures(command_.output / "truth/shot/frames").size(), 3u);
  EXPECT_FALSE(fs::exists(command_.output / "plate.png"));
}

TEST_F(SyntheticShot, AMovingCameraHasAPlateForEachPicture) {
  command_.swing_deg = 20, command_.dolly_m = 0.1;
  RunShot(command_, nullptr);
  const FilmedShot shot = ReadShot(command_.output / "truth/shot/shot.json");
  EXPECT_FALSE(shot.still);
  const auto distance = [&](int i) {  // to the place that it looks at
    return (shot.frames[i].camera_from_world * Eigen::Vector3d(0, 0, 0.09)).norm();
  };
  EXPECT_NEAR(distance(0) - distance(2), 0.1, 1e-9);
  EXPECT_NEAR(distance(1), command_.set.distance_m, 1e-9);
  EXPECT_EQ(FilmPictures(command_.output / "plates").size(), 5u);
  EXPECT_FALSE(fs::exists(command_.output / "plate.png"));
  const Image8 first = ReadImage(command_.output / "plates/0000.png", 3),
               last = ReadImage(command_.output / "plates/0004.png", 3);
  EXPECT_NE(first.data, last.data);
}

TEST_F(SyntheticShot, BadCommandsAreRefused) {
  EXPECT_THROW(ReadShows({"0:rest"}), UsageError);
  EXPECT_THROW(ReadShows({"x=rest"}), UsageError);
  EXPECT_THROW(ReadShows({"0=rest", "0=wave"}), UsageError);
  command_.shows = {{0, "rest"}, {4, "dancing"}};
  EXPECT_THROW(RunShot(command_, nullptr), UsageError);
  command_.shows = {{0, "rest"}};
  command_.set.focal_35mm = 1;
  EXPECT_THROW(RunShot(command_, nullptr), UsageError);
}

}  // namespace keypose::synth::shot_command_test
