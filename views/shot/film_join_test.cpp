#include "views/shot/film_join.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/numbers/picture_times.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::film_join_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

ShotCamera Film(const std::string& name, const std::vector<double>& times_s) {
  FilmIndex index;
  index.times_s = times_s;
  index.rate = RateOf(times_s, 0);
  ShotCamera camera;
  camera.name = name;
  camera.pictures.video = name + ".mp4";
  camera.pictures.frames = SizeOf(times_s);
  camera.pictures.frames_per_second = index.rate.per_second;
  camera.pictures.index = std::make_shared<const FilmIndex>(std::move(index));
  return camera;
}

ShotCamera Folder(const std::string& name, int frames) {
  ShotCamera camera;
  camera.name = name;
  camera.pictures.pictures.resize(static_cast<std::size_t>(frames), "0.png");
  camera.pictures.frames = frames;
  return camera;
}

std::vector<double> Even(int count, double rate, double first = 0) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(first + i / rate);
  return times;
}

std::vector<double> Without(std::vector<double> times, const std::vector<int>& lost) {
  for (auto i = lost.rbegin(); i != lost.rend(); ++i) times.erase(times.begin() + *i);
  return times;
}

std::string Fault(std::vector<ShotCamera> cameras) {
  try {
    JoinFilms(cameras);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(JoinFilms, FilmsThatRunTogetherStayInTheirOrder) {
  std::vector<ShotCamera> cameras{Film("a", Even(50, 30)), Film("b", Even(48, 30, 0.01)),
                                  Film("c", Even(50, 30 / 1.001)), Folder("d", 50)};
  const FilmJoin join = JoinFilms(cameras);
  EXPECT_EQ(join.frames_per_second, 30);
  EXPECT_NEAR(join.worst_s, 0.01, 2e-3);
  for (const ShotCamera& camera : cameras) EXPECT_TRUE(camera.pictures.order.empty());
  EXPECT_EQ(cameras[1].frames(), 48);
}

TEST(JoinFilms, RatesThatDriftApartAreTakenByTime) {
  // 29.97 and 30: after 1000 pictures one has slipped by a frame.
  std::vector<ShotCamera> cameras{Film("a", Even(3000, 30)), Film("b", Even(3000, 30 / 1.001))};
  const FilmJoin join = JoinFilms(cameras);
  EXPECT_LE(join.worst_s, 0.5 / 29.97 * 1.001);
  EXPECT_EQ(cameras[1].pictures.order[2000], 2000);
  EXPECT_EQ(cameras[0].pictures.order[2000], 2002);
}

TEST(JoinFilms, OtherRatesTakeTheSlowestOnesMoments) {
  std::vector<ShotCamera> cameras{Film("a", Even(101, 50)), Film("b", Even(49, 24, 0.25))};
  const FilmJoin join = JoinFilms(cameras);
  EXPECT_NEAR(join.frames_per_second, 24, 1e-9);
  const std::vector<int>&a = cameras[0].pictures.order, &b = cameras[1].pictures.order;
  ASSERT_EQ(b.size(), 49u);
  for (int f = 0; f < SizeOf(a); ++f) {
    EXPECT_EQ(b[f], f);
    EXPECT_LE(std::abs(a[f] / 50.0 - (0.25 + f / 24.0)), 0.010001);
  }
  EXPECT_LE(join.worst_s, 0.010001);
  EXPECT_THAT(join.notes.back(),
              AllOf(HasSubstr("24 a second from 0.250 s on"), HasSubstr(" ms ")));
}

TEST(JoinFilms, PicturesThatOneCameraLacksAreRefusedOrLeftOut) {
  std::vector<ShotCamera> cameras{Film("a", Even(60, 30)),
                                  Film("b", Without(Even(60, 30), {20, 21, 22, 40}))};
  EXPECT_THAT(Fault(cameras),
              AllOf(HasSubstr("at 0.667 s camera b has no picture"), HasSubstr("33.3 ms away"),
                    HasSubstr("half a frame of a, the slowest, is 16.7 ms"),
                    HasSubstr("ffmpeg -i b.mp4 -vf fps=30")));
  JoinFilms(cameras, FilmGaps::kLeftOut);
  ASSERT_EQ(cameras[0].frames(), 56);
  ASSERT_EQ(cameras[1].frames(), 56);
  for (int f = 0; f < 56; ++f)
    EXPECT_NEAR(cameras[0].pictures.index->times_s[cameras[0].pictures.order[f]],
                cameras[1].pictures.index->times_s[cameras[1].pictures.order[f]], 1e-9);
}

TEST(JoinFilms, OneFilmAloneHoldsWhatIsMissing) {
  std::vector<ShotCamera> cameras{Film("a", Without(Even(40, 30), {5, 6, 30}))};
  JoinFilms(cameras);
  const std::vector<int>& order = cameras[0].pictures.order;
  ASSERT_EQ(order.size(), 40u);
  EXPECT_EQ(std::vector<int>(order.begin(), order.begin() + 10),
            (std::vector<int>{0, 1, 2, 3, 4, 4, 4, 5, 6, 7}));
  std::vector<ShotCamera> constant{Film("a", Even(40, 30, 7))};
  JoinFilms(constant);
  EXPECT_TRUE(constant[0].pictures.order.empty());
}

TEST(JoinFilms, WhatHasNoCommonMomentIsRefused) {
  EXPECT_THAT(Fault({Film("a", Even(30, 30)), Film("b", Even(30, 30, 5))}),
              HasSubstr("a ends at 0.97 s, before b begins at 5.00 s"));
  EXPECT_THAT(Fault({Film("a", Even(30, 30)), Film("b", Even(30, 24)), Folder("c", 30)}),
              HasSubstr("the numbered pictures of camera c have no times"));
}

TEST(TakeMasks, OneForEachPictureFollowTheFilm) {
  std::vector<ShotCamera> cameras{Film("a", Even(50, 50)), Film("b", Even(25, 25))};
  JoinFilms(cameras);
  TakeMasks(Folder("a", 50).pictures, &cameras[0]);
  EXPECT_EQ(cameras[0].masks.order, cameras[0].pictures.order);
  EXPECT_EQ(cameras[0].masks.frames, cameras[0].frames());
  TakeMasks(Folder("a", 25).pictures, &cameras[0]);
  EXPECT_TRUE(cameras[0].masks.order.empty()) << "one for each frame";
}

}  // namespace keypose::film_join_test
