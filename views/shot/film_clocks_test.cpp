#include "views/shot/film_clocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "views/decode/testing/test_film.h"
#include "views/shot/shot.h"

namespace keypose::film_clocks_test {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

/// One event, whose second 0 is anywhere before all films.
struct Event {
  double clap_s = 6;
  unsigned seed = 1;
  double moves_s = 60;
};

struct Camera {
  double begin_s = 0;   ///< when its film began
  int rate = 25;        ///< pictures a second
  double seconds = 12;  ///< of its film
  bool sound = true;
  double clock = 1;  ///< seconds of the event in one of its own
};

/// Where something is that goes to and fro, and stops, at no regular times; in [0, 1].
double PlaceAt(const Event& event, double time_s) {
  std::mt19937 random(event.seed);
  std::uniform_real_distribution<double> part(0, 1);
  double begin = -1, from = 0.5;
  for (;;) {
    const double lasts = 0.15 + 0.3 * part(random), rests = 0.8 * part(random), to = part(random);
    if (time_s < begin + lasts) {
      const double x = std::max(0.0, (time_s - begin) / lasts);
      return from + (to - from) * x * x * (3 - 2 * x);
    }
    if (time_s < begin + lasts + rests) return to;
    begin += lasts + rests, from = to;
  }
}

/// A bright square before a dark ground with some grain.
void Paint(const Event& event, const Camera& camera, double time_s, unsigned seed, AVFrame& frame) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> grain(-3, 3);
  const int left = static_cast<int>(100 * PlaceAt(event, camera.begin_s + camera.clock * time_s));
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const bool square = x >= left && x < left + 24 && y >= 6 && y < 26;
      frame.data[0][y * frame.linesize[0] + x] =
          static_cast<std::uint8_t>((square ? 200 : 60) + grain(random));
    }
  for (int plane = 1; plane < 3; ++plane)
    std::fill_n(frame.data[plane], frame.linesize[plane] * frame.height / 2, std::uint8_t{128});
}

std::vector<double> SoundOf(const Event& event, const Camera& camera, int rate, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  std::vector<double> samples;
  for (int i = 0; i < rate * camera.seconds; ++i) {
    const double after = camera.begin_s + camera.clock * i / rate - event.clap_s;
    const double clap = after > 0 && after < 0.4 ? 0.2 * std::exp(-after / 0.03) : 0;
    samples.push_back(std::clamp((0.003 + clap) * noise(random), -1.0, 1.0));
  }
  return samples;
}

class FilmClocksOf : public ::testing::Test, public TestingFolder {
 protected:
  void Film(const std::string& name, const Event& event, const Camera& camera) {
    fs::create_directories(folder_ / "shot");
    TestFilmKind kind;
    kind.rate = camera.rate;
    const unsigned seed = static_cast<unsigned>(name.back());
    if (camera.sound) kind.sound_rate = 44100;
    TestFilm film(folder_ / "shot" / (name + ".mkv"), kind);
    if (camera.sound) film.AddSound(SoundOf(event, camera, kind.sound_rate, seed));
    for (int i = 0; i < camera.rate * camera.seconds; ++i)
      film.Add(std::int64_t{i} * kind.unit / camera.rate, [&](AVFrame& frame) {
        Paint(event, camera, static_cast<double>(i) / camera.rate, 1000 * seed + i, frame);
      });
    film.Finish();
  }
  FilmClocks Found() { return FindFilmClocks(OpenSeparateFilms(folder_ / "shot"), nullptr); }
  Shot Opened(const std::string& offsets) {
    return OpenShot(folder_ / "shot", FilmGaps::kLeftOut, ParseClockWish(offsets));
  }
  std::string Fault(const std::string& offsets) {
    try {
      Opened(offsets);
    } catch (const InputError& error) {
      return error.what();
    } catch (const UsageError& error) {
      return error.what();
    }
    return "none";
  }
};

TEST_F(FilmClocksOf, AClapTellsThemToTwoMilliseconds) {
  Film("a", {}, {.begin_s = 0.0});
  Film("b", {}, {.begin_s = 2.3448, .rate = 30});
  Film("c", {}, {.begin_s = 1.0111, .seconds = 8});
  const FilmClocks found = Found();
  ASSERT_EQ(found.clocks.size(), 3u) << found.notes.at(0);
  EXPECT_EQ(found.clocks.at("a").begin_s, 0);
  EXPECT_NEAR(found.clocks.at("b").begin_s, 2.3448, 0.002);
  EXPECT_NEAR(found.clocks.at("c").begin_s, 1.0111, 0.002);
  EXPECT_THAT(found.notes.at(0), HasSubstr("by sound: a at 0.000 s, b at 2.3"));

  const Shot shot = Opened("auto");
  const std::vector<ShotCamera>& cameras = shot.cameras;
  EXPECT_EQ(shot.frames_per_second, 25);
  // from where the last one began to where the first one ended
  ASSERT_EQ(cameras[0].frames(), cameras[1].frames());
  ASSERT_EQ(cameras[0].frames(), cameras[2].frames());
  EXPECT_NEAR(cameras[0].frames(), (9.0111 - 2.3448) * 25, 1.5);
  for (int f = 0; f < cameras[0].frames(); ++f) {
    const double a = cameras[0].pictures.order[f] / 25.0;
    EXPECT_LE(std::abs(2.3448 + cameras[1].pictures.order[f] / 30.0 - a), 0.022);
    EXPECT_LE(std::abs(1.0111 + cameras[2].pictures.order[f] / 25.0 - a), 0.022);
  }
  EXPECT_LE(shot.join.worst_s, 0.0201);
}

TEST_F(FilmClocksOf, WithoutSoundWhatMovesTellsThemToAQuarterOfAPicture) {
  Film("a", {}, {.begin_s = 5.0, .sound = false});
  Film("b", {}, {.begin_s = 5 + 37.37 / 25, .sound = false});
  Film("c", {}, {.begin_s = 3.871, .rate = 30, .sound = false});
  const FilmClocks found = Found();
  ASSERT_EQ(found.clocks.size(), 3u) << found.notes.at(0);
  EXPECT_NEAR(found.clocks.at("b").begin_s - found.clocks.at("a").begin_s, 37.37 / 25, 0.25 / 25);
  EXPECT_NEAR(found.clocks.at("a").begin_s - found.clocks.at("c").begin_s, 1.129, 0.25 / 25);
  EXPECT_THAT(found.notes.at(0), HasSubstr("by what moves in them"));
}

TEST_F(FilmClocksOf, FilmsThatBeganTogetherStayAsTheyAre) {
  Film("a", {}, {.begin_s = 0.0});
  Film("b", {}, {.begin_s = 0.008});
  for (const bool sound : {true, false}) {
    if (!sound) {
      Film("a", {}, {.begin_s = 0.0, .sound = false});
      Film("b", {}, {.begin_s = 0.02, .sound = false});
    }
    const Shot shot = Opened("auto"), stamps = Opened("off");
    EXPECT_TRUE(shot.join.clocks.empty());
    EXPECT_THAT(shot.join.notes.at(0), HasSubstr("the films' clocks agree"));
    for (const ShotCamera& camera : shot.cameras) EXPECT_TRUE(camera.pictures.order.empty());
    EXPECT_EQ(shot.join.worst_s, stamps.join.worst_s);
  }
}

TEST_F(FilmClocksOf, WhatTellsNothingKeepsTheTimeStampsAndIsSaid) {
  Film("a", {.clap_s = 100, .seed = 1}, {.sound = true});
  Film("b", {.clap_s = 100, .seed = 2}, {.sound = true});
  const Shot shot = Opened("auto");
  EXPECT_TRUE(shot.join.clocks.empty());
  EXPECT_THAT(shot.join.notes.at(0), HasSubstr("neither sound nor motion clearly tells"));
  EXPECT_EQ(shot.cameras[0].frames(), 300);
}

TEST_F(FilmClocksOf, AFilmThatCannotBeJoinedWithOthersThatAreOffsetIsRefused) {
  Film("a", {}, {.begin_s = 0.0});
  Film("b", {}, {.begin_s = 2.5});
  Film("c", {.clap_s = 100, .seed = 7}, {.begin_s = 0, .sound = false});
  EXPECT_THAT(Fault("auto"), HasSubstr("the clocks of cameras a and b differ by -2.50"));
  EXPECT_THAT(Fault("auto"), HasSubstr("tells that of c (the clearest is camera c against"));
  EXPECT_THAT(Fault("auto"), HasSubstr("(of a and b clock_offsets: 0.000,2.50"));
  EXPECT_EQ(Fault("off"), "none");
  Film("b", {}, {.begin_s = 0.0});
  Film("a", {}, {.begin_s = 2.5});
  EXPECT_THAT(Fault("auto"), HasSubstr("the clocks of cameras a and b differ by 2.50"));
  EXPECT_THAT(Fault("auto"), ContainsRegex("of a and b clock_offsets: 2\\.50[0-9],0\\.000"));
}

TEST_F(FilmClocksOf, GivenBeginsAreTaken) {
  Film("a", {}, {});
  Film("b", {}, {});
  const Shot shot = Opened("0,1.33");
  EXPECT_EQ(shot.cameras[0].pictures.order.at(0) - shot.cameras[1].pictures.order.at(0), 33);
  EXPECT_NEAR(shot.join.worst_s, 0.01, 1e-3);
  EXPECT_THAT(Fault("0,1,2"), HasSubstr("has 3 numbers, but there are 2 films"));
  EXPECT_THAT(Fault("0,20"), HasSubstr("a ends at 11.96 s, before b begins at 20.00 s"));
}

TEST_F(FilmClocksOf, ThoseThatAnEarlierStageFoundJoinTheSamePictures) {
  Film("a", {}, {});
  Film("b", {}, {.begin_s = 1.71});
  const Shot found = Opened("auto");
  ClockWish named{.how = ClockWish::How::kGiven, .begins_s = {}, .named = found.join.clocks};
  const Shot again = OpenShot(folder_ / "shot", FilmGaps::kRefused, named);
  for (int c = 0; c < 2; ++c)
    EXPECT_EQ(again.cameras[c].pictures.order, found.cameras[c].pictures.order);
  named.named.erase("b");
  EXPECT_THROW(OpenShot(folder_ / "shot", FilmGaps::kRefused, named), InputError);
}

TEST_F(FilmClocksOf, AClockThatRunsMuchFasterIsRefusedAndALittleFasterIsCorrected) {
  Film("a", {}, {.begin_s = 0.0, .seconds = 60, .sound = false});
  Film("b", {}, {.begin_s = 1.5, .seconds = 60, .sound = false, .clock = 1.003});
  EXPECT_THAT(Fault("auto"), HasSubstr("slower than that of a"));
  Film("b", {}, {.begin_s = 1.5, .seconds = 60, .sound = false, .clock = 1.0015});
  const FilmClocks found = Found();
  ASSERT_EQ(found.clocks.size(), 2u) << found.notes.at(0);
  const FilmClock b = found.clocks.at("b");
  for (const double time : {0.0, 58.0})  // a quarter of a picture
    EXPECT_NEAR(b.rate * time + b.begin_s, 1.0015 * time + 1.5, 0.01);
}

TEST(ClockWishProblems, NameWhatMayBeSaid) {
  for (const char* good : {"auto", "off", "0,1.25", "-1, 2,3"})
    EXPECT_TRUE(ClockWishProblems(good).empty()) << good;
  for (const char* wrong : {"", "3", "on", "0,x", "0,1e9", "0,nan"})
    EXPECT_FALSE(ClockWishProblems(wrong).empty()) << wrong;
}

}  // namespace keypose::film_clocks_test
