#include "export/animation/playback.h"

#include <gtest/gtest.h>

#include "export/animation/testing/boxes.h"
#include "export/animation/texture_blend.h"

namespace keypose::exporting::playback_test {

TEST(LinearKeyframes, StepsKeepTheirOrderInSinglePrecisionLateInALongAnimation) {
  Clip clip;
  for (int i = 0; i < 30000; ++i) clip.picture.push_back(i), clip.stands.push_back(i % 2);
  const auto keyframes = LinearKeyframes(PlaybackMoments(clip, {24, 0, "none"}), clip, 24);
  for (std::size_t i = 1; i < keyframes.size(); ++i)
    ASSERT_GT(static_cast<float>(keyframes[i].seconds),
              static_cast<float>(keyframes[i - 1].seconds))
        << i;
}

TEST(MakeClip, WithoutAWordOfStepsRepeatedPicturesStandToTheirEnd) {
  const Clip clip = MakeClip(Boxes({0, 0, 1, 2, 2, 2, 0}).points, {}, false);
  EXPECT_EQ(clip.picture, (std::vector<int>{0, 0, 2, 3, 3, 3, 0}));
  EXPECT_EQ(clip.stands, (std::vector<char>{1, 1, 0, 1, 1, 1, 0}));
}

TEST(PlaybackMoments, BackwardsPicturesStandWhereTheyDoForwards) {
  const Clip clip = MakeClip(Boxes({0, 0, 1, 2}).points, {1, 1, 0, 0}, false);
  const auto moments = PlaybackMoments(clip, {10, 0, "pingpong"});
  std::vector<int> frames, stands;
  for (const Moment& moment : moments)
    frames.push_back(moment.frame), stands.push_back(moment.stands);
  EXPECT_EQ(frames, (std::vector<int>{0, 1, 2, 3, 2, 1, 0}));
  EXPECT_EQ(stands, (std::vector<int>{1, 1, 0, 0, 1, 1, 0}));
}

TEST(TextureMoments, GoOverFromKeyToKeyWithTheShapeAndStandWhereItStands) {
  // Keys: pose 1, pose 0, pose 1; a hold of one frame at the middle key, then a step to the last.
  Clip clip{{0, 1, 2, 2, 0}, {0, 0, 1, 1, 0}, true};
  const std::vector<double> t{0, 0.25, 1, 1, 2};
  const auto keyframes = LinearKeyframes(PlaybackMoments(clip, {10, 0, "none"}), clip, 10);
  const auto moments = TextureMoments(keyframes, t, {1, 0, 1}, 2);
  ASSERT_EQ(moments.size(), 5u);
  const std::vector<double> seconds{0, 0.1, 0.2, 0.4, 0.4}, second_weight{1, 0.75, 0, 0, 1};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(moments[i].seconds, seconds[i], 2e-4);
    EXPECT_NEAR(moments[i].weights[1], second_weight[i], 1e-12);
    EXPECT_NEAR(moments[i].weights[0] + moments[i].weights[1], 1, 1e-12);
  }
}

TEST(PlaybackMoments, LastFrameComesAtFramesMinusOneOverFps) {
  const Clip clip = MakeClip(Boxes({0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,
                                    13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24})
                                 .points,
                             {}, false);
  const auto moments = PlaybackMoments(clip, {24, 0, "none"});
  ASSERT_EQ(moments.size(), 25u);
  EXPECT_DOUBLE_EQ(moments.back().seconds, 1.0);
}

TEST(PlaybackMoments, LastPictureThatComesAsAStepStandsForAFrame) {
  const auto moments =
      PlaybackMoments(MakeClip(Boxes({0, 0, 1}).points, {1, 1, 0}, false), {10, 0, "none"});
  ASSERT_EQ(moments.size(), 4u);
  EXPECT_DOUBLE_EQ(moments.back().seconds, 0.3);
  EXPECT_EQ(
      PlaybackMoments(MakeClip(Boxes({0, 0, 0}).points, {1, 1, 0}, true), {10, 0, "none"}).size(),
      3u)
      << "a loop goes on at once";
}

}  // namespace keypose::exporting::playback_test
