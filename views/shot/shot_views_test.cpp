#include "views/shot/shot_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::rig_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

RigCalibration RigOf(const std::vector<std::string>& names) {
  RigCalibration rig;
  for (const std::string& name : names) {
    rig.views.emplace_back();
    rig.views.back().name = name;
  }
  return rig;
}

ShotCamera Film(const std::string& name, int frames, bool video = true) {
  FrameSource source;
  if (video) source.video = name + ".mp4";
  source.frames = frames;
  return {name, source, {}, {}};
}

std::vector<std::string> NamesOf(const std::vector<ShotCamera>& films) {
  std::vector<std::string> names;
  for (const ShotCamera& film : films) names.push_back(film.name);
  return names;
}

TEST(TakeOutUncalibrated, BoardsBesideTheFilmsAreNoCamera) {
  for (const auto& calibrated : {RigOf({"cam01", "cam02"}), RigOf({"left", "right", "top"})}) {
    std::vector<ShotCamera> films = {Film("boards", 4, false), Film("cam01", 100),
                                     Film("cam02", 100)};
    EXPECT_THAT(TakeOutUncalibrated(calibrated, films), ElementsAre("boards"));
    EXPECT_THAT(NamesOf(films), ElementsAre("cam01", "cam02"));
  }
}

TEST(TakeOutUncalibrated, AFilmThatTheCalibrationLacksStaysAndIsAnError) {
  for (const bool video : {true, false}) {
    std::vector<ShotCamera> films = {Film("cam01", 100, video), Film("cam02", 90, video)};
    const RigCalibration rig = RigOf({"cam01"});
    EXPECT_THAT(TakeOutUncalibrated(rig, films), IsEmpty());
    EXPECT_THROW(MatchedViews(rig, NamesOf(films), "track"), InputError);
  }
}

TEST(TakeOutUncalibrated, AShortFilmOfACalibratedCameraStays) {
  std::vector<ShotCamera> films = {Film("cam01", 5, false), Film("cam02", 100)};
  EXPECT_THAT(TakeOutUncalibrated(RigOf({"cam01", "cam02", "cam03"}), films), IsEmpty());
  EXPECT_THAT(NamesOf(films), ElementsAre("cam01", "cam02"));
}

}  // namespace keypose::rig_test
