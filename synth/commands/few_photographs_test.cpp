// A pose of which only a few photographs are taken, from cameras of another pose's rig.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "synth/commands/photos_command.h"
#include "synth/photographs/truth_files.h"

namespace keypose::synth::few_photographs_test {

namespace fs = std::filesystem;

TEST(SpreadOverRings, SixOfThirtySixAreSixtyDegreesApart) {
  PhotographerOptions rig;
  rig.views = 36;
  EXPECT_EQ(SpreadOverRings(rig, 6), (std::vector<int>{0, 6, 12, 21, 27, 33}));
}

TEST(SpreadOverRings, EveryNumberGivesDistinctViewsOfTheRig) {
  for (const std::vector<double>& rings :
       {std::vector<double>{20}, std::vector<double>{12, 40}, std::vector<double>{0, 20, 40}}) {
    PhotographerOptions rig;
    rig.elevations_deg = rings;
    rig.views = 17;
    for (int count = 1; count <= 17; ++count) {
      const std::vector<int> chosen = SpreadOverRings(rig, count);
      ASSERT_EQ(static_cast<int>(chosen.size()), count);
      EXPECT_GE(chosen.front(), 0);
      EXPECT_LT(chosen.back(), 17);
      for (std::size_t i = 1; i < chosen.size(); ++i) EXPECT_LT(chosen[i - 1], chosen[i]);
    }
  }
}

TEST(ReadFew, TakesPoseAndNumberAndRefusesOthers) {
  EXPECT_EQ(ReadFew({"wave=6", "bent=12"}),
            (std::map<std::string, int>{{"wave", 6}, {"bent", 12}}));
  for (const char* text : {"wave", "wave=", "=6", "wave=six", "wave=6x"})
    EXPECT_THROW(ReadFew({text}), UsageError) << text;
}

class FewPhotographs : public ::testing::Test {
 protected:
  static PhotosCommand Command(const fs::path& output) {
    PhotosCommand command;
    command.output = output;
    command.world.spacing_m = 0.008;
    command.photographer.views = 8;
    command.photographer.width = 120, command.photographer.height = 90;
    command.poses = {"rest", "wave", "limbs"};
    command.few = {{"wave", 4}, {"limbs", 2}};
    return command;
  }
  static void SetUpTestSuite() {
    own_ = std::make_unique<TestingFolder>();
    folder_ = own_->path();
    written_ = RunPhotos(Command(folder_), nullptr);
  }
  static void TearDownTestSuite() { own_.reset(); }
  static inline std::unique_ptr<TestingFolder> own_;
  static inline fs::path folder_;
  static inline int written_ = 0;
};

TEST_F(FewPhotographs, AreTakenWithTheCamerasOfTheRig) {
  EXPECT_EQ(written_, 8 + 4 + 2);
  const Truth rest = ReadTruth(folder_ / "truth/rest"), wave = ReadTruth(folder_ / "truth/wave");
  ASSERT_EQ(wave.cameras.views.size(), 4u);
  EXPECT_EQ(wave.cameras.views[3].name, "IMG_0004.jpg");
  const auto world = nlohmann::json::parse(ReadFile(folder_ / "truth/wave/world.json"));
  EXPECT_EQ(world.at("photographs").at("views"), 4);
  for (int i = 0; i < 4; ++i) {
    const std::string of_rig = world.at("rig_photographs").at(i);
    for (const View& view : rest.cameras.views)
      if (view.name == of_rig) {
        EXPECT_EQ(view.Center(), wave.cameras.views[i].Center()) << of_rig;
      }
  }
  EXPECT_EQ(wave.surface.faces, rest.surface.faces);
  EXPECT_GT((wave.surface.points - rest.surface.points).rowwise().norm().maxCoeff(), 0.02);
}

TEST_F(FewPhotographs, ShowThePoseAndNotTheRigs) {
  // The mask is that of the waving figure seen by that camera: the same as of a whole set.
  PhotosCommand all = Command(folder_ / "all");
  all.poses = {"rest"}, all.few = {};
  const World world = MakeWorld(all.world);
  const Photographer rig(world, world.PoseNamed("rest"), all.photographer);
  const Photographer wave(world, world.PoseNamed("wave"), all.photographer, &rig);
  const std::vector<int> chosen = SpreadOverRings(all.photographer, 4);
  EXPECT_EQ(ReadImage(folder_ / "truth/wave/masks/IMG_0002.jpg.png").data,
            wave.Take(chosen[1]).mask.data);
}

TEST_F(FewPhotographs, LimbAnglesAreInTheTruth) {
  const auto world = nlohmann::json::parse(ReadFile(folder_ / "truth/limbs/world.json"));
  EXPECT_EQ(world.at("pose_seed"), 1);
  ASSERT_EQ(world.at("limbs_deg").size(), 4u);
  for (const auto& [limb, angle] : world.at("limbs_deg").items()) {
    EXPECT_GE(angle.get<double>(), 30) << limb;
    EXPECT_LE(angle.get<double>(), 120) << limb;
  }
}

TEST_F(FewPhotographs, RigIsThatOfTheRestPoseWhenAllPosesAreFew) {
  PhotosCommand alone = Command(folder_ / "alone");
  alone.poses = {"wave"}, alone.few = {{"wave", 4}};
  EXPECT_EQ(RunPhotos(alone, nullptr), 4);
  EXPECT_EQ(ReadFile(folder_ / "alone/photos/wave/IMG_0003.jpg"),
            ReadFile(folder_ / "photos/wave/IMG_0003.jpg"));
}

TEST_F(FewPhotographs, BadCommandsAreNamed) {
  PhotosCommand command = Command(folder_ / "bad");
  command.few["bow"] = 3;
  EXPECT_THROW(RunPhotos(command, nullptr), UsageError);
  command = Command(folder_ / "bad");
  command.few["wave"] = 9;
  EXPECT_THROW(RunPhotos(command, nullptr), UsageError);
}

}  // namespace keypose::synth::few_photographs_test
