#include "reconstruct/known/known_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/values/errors.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::known_cameras_test {

using ::testing::HasSubstr;
using testing::LookFrom;

Camera TestCamera() {
  Camera camera;
  camera.width = 1440, camera.height = 1080;
  camera.fx = camera.fy = 2400, camera.cx = 720, camera.cy = 540;
  camera.k1 = -0.05;
  return camera;
}

TEST(MatchKnownPoses, NamesMatchByStemAndIntrinsicsFollowTheSize) {
  View view = LookFrom({1, 0, 1}, TestCamera(), "images/../b");
  view.name = "b";
  view.camera = TestCamera().Scaled(0.5);
  View shares = LookFrom({0, 1, 1}, Camera{}, "a.png");
  shares.camera.fx = shares.camera.fy = -2400.0 / 1440;
  Camera photograph, small;
  photograph.width = 1440, photograph.height = 1080;
  small.width = 720, small.height = 540;
  const auto matched =
      MatchKnownPoses({view, shares}, {"a.png", "b.jpg", "c.jpg"}, {small, photograph, photograph});
  ASSERT_EQ(matched.size(), 2u);
  EXPECT_EQ(matched[0].name, "a.png");
  EXPECT_NEAR(matched[0].camera.fx, 1200, 1e-9);
  EXPECT_EQ(matched[0].camera.cx, 360);
  EXPECT_EQ(matched[1].name, "b.jpg");
  EXPECT_NEAR(matched[1].camera.fx, 2400, 1e-9);
  EXPECT_EQ(matched[1].camera.width, 1440);
}

std::string MessageOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MatchKnownPoses, SubfoldersWithEqualNamesAreToldApart) {
  Camera size;
  size.width = 1440, size.height = 1080;
  const View left = LookFrom({1, 0, 1}, TestCamera(), "left/0001.jpg"),
             right = LookFrom({0, 1, 1}, TestCamera(), "images\\right\\0001.png");
  const auto matched =
      MatchKnownPoses({left, right}, {"left_0001.jpg", "right_0001.jpg"}, {size, size});
  ASSERT_EQ(matched.size(), 2u);
  EXPECT_LT((matched[0].Center() - left.Center()).norm(), 1e-12);
  EXPECT_LT((matched[1].Center() - right.Center()).norm(), 1e-12);
  EXPECT_EQ(MatchKnownPoses({left}, {"0001.jpg"}, {size})[0].name, "0001.jpg");
  EXPECT_THROW(MatchKnownPoses({left, right}, {"0001.jpg"}, {size}), InputError);
}

TEST(MatchKnownPoses, NamesWithDotsAndNoEndingAreWhole) {
  Camera size;
  size.width = 1440, size.height = 1080;
  const View one = LookFrom({1, 0, 1}, TestCamera(), "b.1"),
             other = LookFrom({0, 1, 1}, TestCamera(), "b");
  const auto matched = MatchKnownPoses({one, other}, {"b.1.jpg", "b.jpg"}, {size, size});
  ASSERT_EQ(matched.size(), 2u);
  EXPECT_LT((matched[0].Center() - one.Center()).norm(), 1e-12);
  EXPECT_LT((matched[1].Center() - other.Center()).norm(), 1e-12);
}

TEST(MatchKnownPoses, StrangersTwinsAndOtherShapesAreInputErrors) {
  Camera photograph;
  photograph.width = 1440, photograph.height = 1080;
  const View a = LookFrom({1, 0, 1}, TestCamera(), "a.jpg"),
             stranger = LookFrom({1, 1, 1}, TestCamera(), "z9.jpg");
  View twin = a, wide = a;
  twin.name = "a";
  wide.camera.width = 1920;
  EXPECT_THAT(MessageOf([&] {
                MatchKnownPoses({a, stranger}, {"a.jpg"}, {photograph});
              }),
              HasSubstr("not in the set: z9.jpg"));
  EXPECT_THAT(MessageOf([&] {
                MatchKnownPoses({a, twin}, {"a.jpg"}, {photograph});
              }),
              HasSubstr("two cameras for a.jpg"));
  EXPECT_THAT(MessageOf([&] { MatchKnownPoses({wide}, {"a.jpg"}, {photograph}); }),
              HasSubstr("1920 x 1080"));
}

}  // namespace keypose::reconstruct::known_cameras_test
