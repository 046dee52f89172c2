// Masks of a painted actor in a painted room, whose truth is known.
#include "capture/films/film_masks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "capture/segmentation/trimap.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture::film_masks_test {

constexpr int kWidth = 256, kHeight = 192, kFrames = 36;

/// A wall with pictures, a floor, a shelf: each of its own colour and texture.
cv::Mat Room() {
  cv::Mat room(kHeight, kWidth, CV_8UC3);
  cv::RNG random(7);
  cv::randu(room, cv::Scalar::all(0), cv::Scalar::all(40));
  cv::GaussianBlur(room, room, {5, 5}, 1);
  room(cv::Rect(0, 0, kWidth, 140)) += cv::Scalar(150, 140, 120);
  room(cv::Rect(0, 140, kWidth, kHeight - 140)) += cv::Scalar(60, 65, 75);
  for (int i = 0; i < 9; ++i) {
    const cv::Point corner(random.uniform(0, 230), random.uniform(10, 110));
    const cv::Scalar colour(random.uniform(20, 230), random.uniform(20, 230),
                            random.uniform(20, 230));
    cv::rectangle(room, cv::Rect(corner, cv::Size(18, 24)), colour, -1);
  }
  return room;
}

struct Filmed {
  cv::Mat picture, truth;
};

struct Play {
  double sway = 26;     ///< how far the actor moves to either side [px]
  bool second = false;  ///< another person at the right edge
  double exposure = 0;  ///< change of the exposure in the course of the film [stops]
  double noise = 1.5;   ///< standard deviation [grey levels]
  cv::Scalar skin{190, 130, 105}, cloth{40, 60, 140};
};

void DrawPerson(cv::Mat& on, double x, double swing, double size, const cv::Scalar& skin,
                const cv::Scalar& cloth) {
  const auto at = [&](double dx, double y) {
    return cv::Point(static_cast<int>(std::lround(16 * (x + size * dx))),
                     static_cast<int>(std::lround(16 * (96 + size * (y - 96)))));
  };
  const auto limb = [&](double x0, double y0, double x1, double y1, double wide,
                        const cv::Scalar& colour) {
    cv::line(on, at(x0, y0), at(x1, y1), colour, static_cast<int>(size * wide), cv::LINE_8, 4);
  };
  limb(0, 120, -10 - 8 * swing, 165, 11, cloth);
  limb(0, 120, 10 + 4 * swing, 168, 11, cloth);
  limb(0, 70, 0, 118, 28, cloth);
  limb(0, 72, -26 - 6 * swing, 95 - 40 * swing, 9, skin);
  limb(0, 72, 28, 100 + 20 * swing, 9, skin);
  cv::circle(on, at(2 * swing, 42), static_cast<int>(16 * size * 12), skin, -1, cv::LINE_8, 4);
}

Filmed FrameOf(const Play& play, int frame) {
  const double t = 2 * CV_PI * frame / kFrames;
  Filmed filmed{Room(), cv::Mat::zeros(kHeight, kWidth, CV_8U)};
  const double x = 110 + play.sway * std::sin(t), swing = std::cos(2 * t);
  if (play.second)
    DrawPerson(filmed.picture, 238 + 5 * std::sin(3 * t), std::sin(5 * t), 0.6, {90, 160, 90},
               {150, 40, 40});
  DrawPerson(filmed.picture, x, swing, 1, play.skin, play.cloth);
  DrawPerson(filmed.truth, x, swing, 1, cv::Scalar::all(255), cv::Scalar::all(255));
  filmed.picture.convertTo(filmed.picture, CV_32F,
                           std::exp2(play.exposure * std::sin(t / 2) / 2.2));
  cv::Mat noise(filmed.picture.size(), CV_32FC3);
  cv::RNG random(static_cast<std::uint64_t>(frame) + 1);
  random.fill(noise, cv::RNG::NORMAL, 0, play.noise);
  filmed.picture += noise;
  filmed.picture.convertTo(filmed.picture, CV_8U);
  return filmed;
}

FilmSample SampleOf(const Play& play, const std::vector<ToldFrame>& told = {}) {
  FilmSample sample;
  sample.frames = FramesToLearnFrom(kFrames, told);
  for (const int f : sample.frames) sample.pictures.push_back(ImageOf(FrameOf(play, f).picture));
  return sample;
}

double Overlap(const Image8& mask, const cv::Mat& truth) {
  const cv::Mat found = MatOf(mask) > 127;
  return static_cast<double>(cv::countNonZero(found & truth)) / cv::countNonZero(found | truth);
}

/// The mean overlap with the truth, and the worst.
std::pair<double, double> OverlapsOf(FilmMasker& masker, const Play& play) {
  double sum = 0, worst = 1;
  for (int f = 0; f < kFrames; ++f) {
    const Filmed filmed = FrameOf(play, f);
    const double overlap =
        Overlap(masker.Choose(f, masker.Regions(f, ImageOf(filmed.picture))), filmed.truth);
    sum += overlap;
    worst = std::min(worst, overlap);
  }
  return {sum / kFrames, worst};
}

TEST(FilmMasker, FindsAnActorWhoNeverLeavesHisPlaceWithoutAPlate) {
  const Play play;
  FilmMasker masker(SampleOf(play), {}, {}, {});
  const auto [mean, worst] = OverlapsOf(masker, play);
  EXPECT_GT(mean, 0.95);
  EXPECT_GT(worst, 0.9);
  EXPECT_TRUE(masker.Warnings("cam1").empty());
}

TEST(FilmMasker, AnotherPersonAtTheEdgeIsLeftOut) {
  Play play;
  play.second = true;
  FilmMasker masker(SampleOf(play), {}, {}, {});
  const auto [mean, worst] = OverlapsOf(masker, play);
  EXPECT_GT(mean, 0.94);
  EXPECT_GT(worst, 0.88);
}

TEST(FilmMasker, AutomaticExposureIsEvenedAndNamed) {
  Play play;
  play.exposure = 0.5;
  FilmMasker masker(SampleOf(play), {}, {}, {});
  const auto [mean, worst] = OverlapsOf(masker, play);
  EXPECT_GT(mean, 0.94);
  EXPECT_GT(worst, 0.88);
  const std::vector<std::string> warnings = masker.Warnings("cam1");
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("exposure"), std::string::npos);
}

TEST(FilmMasker, AStrokeSaysWhichOfTwoIsTheActor) {
  Play play;
  play.second = true;
  ToldFrame told{5, Image8(kWidth, kHeight, 1)};
  for (int y = 75; y < 95; ++y) *told.trimap.at(238, y) = kObject;  // the one at the edge
  FilmMasker masker(SampleOf(play, {told}), {told}, {}, {});
  const Image8 mask = masker.Choose(5, masker.Regions(5, ImageOf(FrameOf(play, 5).picture)));
  EXPECT_EQ(*mask.at(240, 85), 255);
  EXPECT_EQ(*mask.at(125, 90), 0) << "the large one is not meant";
}

TEST(FilmMasker, SameBitsForAnyThreadCount) {
  const Play play;
  std::vector<Image8> masks[2];
  for (const int threads : {1, 3}) {
    SetThreadCount(threads);
    FilmMasker masker(SampleOf(play), {}, {}, {});
    for (const int f : {0, 17}) {
      const Image8 picture = ImageOf(FrameOf(play, f).picture);
      masks[threads == 3].push_back(masker.Choose(f, masker.Regions(f, picture)));
    }
  }
  SetThreadCount(0);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(masks[0][i].data, masks[1][i].data);
}

TEST(FilmMasker, FilmInWhichNothingMovesIsRefusedWithTheCure) {
  FilmSample sample;
  sample.frames = {0, 1, 2};
  for (int i = 0; i < 3; ++i) sample.pictures.push_back(ImageOf(Room()));
  try {
    FilmMasker masker(sample, {}, {}, {});
    FAIL() << "a still film was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("background/"), std::string::npos);
  }
}

}  // namespace keypose::capture::film_masks_test
