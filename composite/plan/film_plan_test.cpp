#include "composite/plan/film_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "core/values/errors.h"

namespace keypose::composite::film_plan_test {

using ::testing::HasSubstr;

FilmedShot ShotWith(const std::vector<std::pair<int, std::string>>& frames, double fps = 12) {
  FilmedShot shot;
  shot.fps = fps;
  for (const auto& [number, pose] : frames) {
    ShotFrame frame;
    frame.frame = number, frame.pose = pose;
    shot.frames.push_back(frame);
  }
  return shot;
}

std::string KindsOf(const FilmPlan& plan) {
  std::string kinds;
  for (const PlannedPicture& picture : plan.pictures)
    kinds += "FBH"[static_cast<int>(picture.kind)];
  return kinds;
}

std::string FaultOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(PlanFilm, TwelveBecomeTwentyFour) {
  const FilmPlan plan =
      PlanFilm(ShotWith({{0, "rest"}, {2, "wave"}}), {0, 1, 2}, {24, 5, {0, 4}, {}});
  EXPECT_EQ(KindsOf(plan), "FBFBF");
  EXPECT_EQ(plan.pictures[3].animation, 3);
  EXPECT_EQ(plan.pictures[4].filmed, 2);
  EXPECT_EQ(plan.filmed, 3);
  EXPECT_EQ(plan.between, 2);
}

TEST(PlanFilm, RatesOfTelevisionAreAsTyped) {
  const double ntsc = 24000.0 / 1001;
  for (const auto& [film, animation] :
       {std::pair{ntsc / 2, 23.976}, {11.988, ntsc}, {14.985, 29.97}})
    EXPECT_EQ(
        PlanFilm(ShotWith({{0, "rest"}, {2, "wave"}}, film), {0, 1, 2}, {animation, 5, {0, 4}, {}})
            .per_frame,
        2)
        << film;
  EXPECT_THAT(FaultOf([&] {
                PlanFilm(ShotWith({{0, "rest"}}), {0}, {23.976, 5, {0, 4}, {}});
              }),
              HasSubstr("must be a multiple"))
      << "a film of 12 would run away from it";
}

TEST(PlanFilm, GapsInTheFilmAreFilledAndEndsStand) {
  // The character enters at frame 1; frame 3 was not filmed; frame 5 comes after the last key.
  const FilmPlan plan =
      PlanFilm(ShotWith({{1, "rest"}, {4, "wave"}}), {0, 1, 2, 4, 5}, {24, 7, {0, 6}, {}});
  EXPECT_EQ(KindsOf(plan), "FHFBFBBBFHF");
  EXPECT_EQ(plan.start, 2);
  EXPECT_EQ(plan.first_frame, 1);
  EXPECT_EQ(plan.pictures[1].filmed, 0);
  EXPECT_EQ(plan.pictures[6].animation, 4);
  EXPECT_EQ(plan.held, 2);
}

TEST(PlanFilm, WithoutFilmEveryFrameIsRendered) {
  const FilmPlan plan = PlanFilm(ShotWith({{3, "rest"}}), {}, {12, 4, {}, {}});
  EXPECT_EQ(KindsOf(plan), "BBBB");
  EXPECT_EQ(plan.pictures[0].animation, 0);
}

TEST(PlanFilm, WithoutFilmACameraIsEnough) {
  const FilmPlan plan = PlanFilm(ShotWith({{2, ""}, {3, ""}}), {}, {24, 3, {0, 2}, {}});
  EXPECT_EQ(KindsOf(plan), "BBB");
  EXPECT_EQ(plan.pictures[0].animation, 0);
  EXPECT_EQ(plan.first_frame, 2);
}

TEST(PlanFilm, WhatDoesNotFitIsRefused) {
  const FilmedShot shot = ShotWith({{0, "rest"}, {2, "wave"}});
  EXPECT_THAT(FaultOf([&] { PlanFilm(shot, {0, 1, 2}, {25, 5, {}, {}}); }), HasSubstr("multiple"));
  EXPECT_THAT(FaultOf([&] {
                PlanFilm(shot, {0, 1, 2}, {24, 5, {0, 3}, {}});
              }),
              HasSubstr("at the animation's frames 0, 4, but the animation has its keys at 0, 3"));
  EXPECT_THAT(FaultOf([&] {
                PlanFilm(ShotWith({{0, ""}}), {0}, {24, 5, {}, {}});
              }),
              HasSubstr("no frame of the shot shows a key pose"));
}

}  // namespace keypose::composite::film_plan_test
