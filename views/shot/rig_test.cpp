#include "views/shot/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors.h"

namespace keypose {
namespace {

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

std::vector<ShotCamera> Films(const std::vector<std::string>& names) {
  std::vector<ShotCamera> films;
  for (const std::string& name : names) films.push_back({name, {}, {}, {}});
  return films;
}

std::vector<std::string> NamesOf(const std::vector<ShotCamera>& films) {
  std::vector<std::string> names;
  for (const ShotCamera& film : films) names.push_back(film.name);
  return names;
}

TEST(TakeOutUncalibrated, BoardsBesideTheFilmsOfAllCamerasAreNoCamera) {
  std::vector<ShotCamera> films = Films({"boards", "cam01", "cam02"});
  EXPECT_THAT(TakeOutUncalibrated(RigOf({"cam01", "cam02"}), films), ElementsAre("boards"));
  EXPECT_THAT(NamesOf(films), ElementsAre("cam01", "cam02"));
}

TEST(TakeOutUncalibrated, AFilmThatMayBeAMissingCameraStaysAndIsAnError) {
  std::vector<ShotCamera> films = Films({"cam01", "left"});
  const RigCalibration rig = RigOf({"cam01", "cam02", "cam03"});
  EXPECT_THAT(TakeOutUncalibrated(rig, films), IsEmpty());
  EXPECT_THAT(NamesOf(films), ElementsAre("cam01", "left"));
  EXPECT_THROW(MatchedViews(rig, NamesOf(films), "track"), InputError);
}

TEST(TakeOutUncalibrated, CamerasWithoutAFilmAreNotMissed) {
  std::vector<ShotCamera> films = Films({"cam01", "cam02"});
  EXPECT_THAT(TakeOutUncalibrated(RigOf({"cam01", "cam02", "cam03"}), films), IsEmpty());
  EXPECT_THAT(NamesOf(films), ElementsAre("cam01", "cam02"));
}

}  // namespace
}  // namespace keypose
